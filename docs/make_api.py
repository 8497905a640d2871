"""Write docs/api/: the public names of every package that users meet, from their docstrings.

Run from anywhere; a test asks that the files are current::

    python docs/make_api.py [FOLDER]
"""

import ast
import dataclasses
import importlib
import inspect
import re
import sys
import textwrap
import typing
from pathlib import Path
from types import ModuleType
from typing import Any

FOLDER = Path(__file__).resolve().parent / "api"

PACKAGES = {
    "indoorfit": "The whole way in three names: read, fit, write.",
    "indoorfit.model": "What comes out of a fit, and what goes in.",
    "indoorfit.io": "Files to typed values and back.",
    "indoorfit.simulate": "Rooms and scanners with exact truth.",
    "indoorfit.evaluate": "A model against a truth.",
    "indoorfit.batch": "Many scans at once.",
    "indoorfit.pipeline": "The steps behind `fit` and the commands.",
}


def pages() -> dict[str, str]:
    """Name of the file and its text, for every page."""
    found = {f"{name}.md": page(name, about) for name, about in PACKAGES.items()}
    lines = [f"- [{name}]({name}.md): {about}" for name, about in PACKAGES.items()]
    head = "# API reference\n\nWritten by `python docs/make_api.py` from the docstrings.\n\n"
    return {"README.md": head + "\n".join(lines) + "\n", **found}


def page(package: str, about: str) -> str:
    """All public names of a package, alphabetically."""
    module = importlib.import_module(package)
    parts = [f"# {package}\n\n{about}\n"]
    parts += [entry(name, getattr(module, name)) for name in sorted(public(module), key=str.lower)]
    return "\n".join(parts)


def public(module: ModuleType) -> list[str]:
    """`__all__`, or what the package's `__init__` imports by its own name."""
    if hasattr(module, "__all__"):
        return list(module.__all__)
    tree = ast.parse(inspect.getsource(module))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    return [alias.asname for node in imports for alias in node.names if alias.asname == alias.name]


def entry(name: str, thing: Any) -> str:
    """One name: what it is, how it is called, what it says of itself."""
    if inspect.isclass(thing):
        return class_entry(name, thing)
    if inspect.isfunction(thing):
        return f"## `{name}`\n\n```text\n{signature(name, thing)}\n```\n\n{told(thing)}\n"
    return f"## `{name}`\n\n{constant(thing)}\n"


def constant(thing: Any) -> str:
    """The values of a type of words; of other constants only that they are there."""
    values = typing.get_args(thing) if typing.get_origin(thing) is typing.Literal else ()
    return f"One of {', '.join(f'`{value}`' for value in values)}." if values else "A constant or a type."


def class_entry(name: str, kind: type) -> str:
    """A class with its fields, its properties and its methods."""
    lines = [f"## `{name}`\n", told(kind), ""]
    if dataclasses.is_dataclass(kind):
        lines += [*fields(kind), ""]
    for member, value in vars(kind).items():
        if member.startswith("_"):
            continue
        if isinstance(value, property):
            lines.append(f"- `.{member}`: {first_line(value)}")
        elif inspect.isfunction(value):
            lines.append(
                f"\n### `{name}.{member}`\n\n```text\n{signature(member, value)}\n```\n\n{told(value)}"
            )
    return "\n".join(lines).rstrip() + "\n"


def signature(name: str, function: Any) -> str:
    """The call as it is written in the source, a parameter per line where it is long."""
    node = source_of(function)
    assert isinstance(node, ast.FunctionDef)
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    one_line = f"{name}({ast.unparse(node.args)}){returns}"
    if len(one_line) <= 100:
        return one_line
    given = node.args
    ordinary = [*given.posonlyargs, *given.args]
    defaults = [*[None] * (len(ordinary) - len(given.defaults)), *given.defaults]
    parameters = [parameter(*pair) for pair in zip(ordinary, defaults, strict=True)]
    if given.kwonlyargs:
        named = zip(given.kwonlyargs, given.kw_defaults, strict=True)
        parameters += ["*", *(parameter(*pair) for pair in named)]
    inner = "".join(f"    {text},\n" for text in parameters)
    return f"{name}(\n{inner}){returns}"


def parameter(argument: ast.arg, default: ast.expr | None) -> str:
    """One parameter with its type and its default."""
    return ast.unparse(argument) + ("" if default is None else f" = {ast.unparse(default)}")


def fields(kind: type) -> list[str]:
    """The fields of a dataclass, inherited ones first, each with the string under it."""
    lines = []
    for base in reversed(kind.__mro__[:-1]):
        node = source_of(base)
        if not isinstance(node, ast.ClassDef):
            continue
        for field, following in zip(node.body, [*node.body[1:], None], strict=True):
            if isinstance(field, ast.AnnAssign):
                says = following.value if isinstance(following, ast.Expr) else None
                text = " ".join(str(says.value).split()) if isinstance(says, ast.Constant) else ""
                lines.append(f"- `{ast.unparse(field)}`{': ' if text else ''}{text}")
    return lines


def source_of(thing: Any) -> ast.stmt | None:
    """The definition in the source: types as people wrote them, whatever the versions of libraries."""
    try:
        return ast.parse(textwrap.dedent(inspect.getsource(inspect.unwrap(thing)))).body[0]
    except (OSError, TypeError):
        return None


def told(thing: Any) -> str:
    """The docstring; indented parts (Args, Returns, Raises) as literal text."""
    text = inspect.getdoc(thing) or ""
    head, *rest = re.split(r"\n(?=(?:Args|Returns|Yields|Raises|Source):)", text, maxsplit=1)
    body = head.strip()
    return f"{body}\n\n```text\n{rest[0].rstrip()}\n```" if rest else body


def first_line(thing: Any) -> str:
    """The first sentence of a docstring."""
    return " ".join((inspect.getdoc(thing) or "").split("\n\n")[0].split())


def main(folder: Path) -> None:
    """Write the folder anew."""
    folder.mkdir(parents=True, exist_ok=True)
    written = pages()
    for old in folder.glob("*.md"):
        if old.name not in written:
            old.unlink()
    for name, text in written.items():
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
