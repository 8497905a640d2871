"""Write default.toml: every setting with its default and the reason for it, from the source itself.

python configs/make_default.py
"""

import ast
import dataclasses
import inspect
import json
import sys
import textwrap
from pathlib import Path
from typing import Any

from indoorfit import RunConfig

HEAD = """\
# Every setting of `indoorfit fit --config`, with its default and the reason for it.
# Written by configs/make_default.py from the source; a test keeps it up to date.
# A file of your own needs only the settings that it changes. Unknown keys are errors.
"""


def document(config: RunConfig) -> str:
    """The settings as TOML, each under its reason."""
    return "\n".join([HEAD, *_table(config, ())])


def reasons(kind: type) -> dict[str, str]:
    """The string under each field of a dataclass, on one line."""
    body = ast.parse(textwrap.dedent(inspect.getsource(kind))).body[0]
    assert isinstance(body, ast.ClassDef)
    found = {}
    for field, text in zip(body.body, body.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr):
            assert isinstance(field.target, ast.Name)
            assert isinstance(text.value, ast.Constant)
            found[field.target.id] = " ".join(str(text.value.value).split())
    return found


def _table(config: Any, path: tuple[str, ...]) -> list[str]:
    """Plain settings first: in TOML a table ends where the next one begins."""
    why, lines, tables = reasons(type(config)), [], []
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value):
            tables += _table(value, (*path, field.name))
            continue
        lines += [f"# {line}" for line in textwrap.wrap(why.get(field.name, ""), 100)]
        # TOML has no null: a setting that is off by default is shown as a comment.
        lines += [f"# {field.name} = ..." if value is None else f"{field.name} = {_literal(value)}", ""]
    if path and lines:
        about = (inspect.getdoc(type(config)) or "").splitlines()[0]
        lines = [f"# {about}", f"[{'.'.join(path)}]", *lines]
    return lines + tables


def _literal(value: Any) -> str:
    # JSON writes strings, numbers, booleans and lists as TOML does.
    return json.dumps(list(value) if isinstance(value, tuple) else value)


if __name__ == "__main__":
    target = Path(__file__).with_name("default.toml")
    target.write_text(document(RunConfig()), encoding="utf-8")
    sys.stdout.write(f"{target}\n")
