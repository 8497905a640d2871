"""JSON values that know where they stand in their file, so that a wrong one can be named."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from jaxtyping import Float

from ..errors import InputError


class JsonNode:
    """One value of a JSON document. Every accessor checks the type and raises InputError if it differs."""

    def __init__(self, value: Any, file: str, path: str = "") -> None:
        self.value = value
        self.file = file
        self.path = path

    def fail(self, found: str, needed: str) -> NoReturn:
        """Raise the InputError that says what was found here."""
        at = f"{self.file}: {self.path or 'the document'}"
        raise InputError(f"{at} is {found}; {needed} is needed. Fix: repair the file or write it again.")

    def __getitem__(self, key: str) -> "JsonNode":
        """The value under a key, which must be there."""
        if not isinstance(self.value, dict):
            self.fail(self._kind(), "an object")
        if key not in self.value:
            JsonNode(None, self.file, self._below(key)).fail("missing", "a value")
        return JsonNode(self.value[key], self.file, self._below(key))

    def optional(self, key: str) -> "JsonNode":
        """The value under a key; null where there is none."""
        if isinstance(self.value, dict) and key not in self.value:
            return JsonNode(None, self.file, self._below(key))
        return self[key]

    def items(self) -> Iterator["JsonNode"]:
        """The elements of a list."""
        if not isinstance(self.value, list):
            self.fail(self._kind(), "a list")
        for index, element in enumerate(self.value):
            yield JsonNode(element, self.file, f"{self.path}[{index}]")

    def text(self) -> str:
        """A string."""
        if not isinstance(self.value, str):
            self.fail(self._kind(), "a string")
        try:
            self.value.encode("utf-8")
        except UnicodeEncodeError:
            # JSON may hold half a character (\ud800), which no file can be written with.
            self.fail("half a character", "text")
        return self.value

    def text_or_none(self) -> str | None:
        """A string or null."""
        return None if self.value is None else self.text()

    def choice(self, *allowed: str) -> Any:
        """One of the given strings. Typed Any, for the caller's Literal knows the choices."""
        if self.value not in allowed:
            self.fail(repr(self.value)[:60], " or ".join(allowed))
        return self.value

    def truth(self) -> bool:
        """true or false."""
        if not isinstance(self.value, bool):
            self.fail(self._kind(), "true or false")
        return self.value

    def integer(self, low: int | None = None, high: int | None = None) -> int:
        """A whole number, within the given limits (both included)."""
        if isinstance(self.value, bool) or not isinstance(self.value, int):
            self.fail(self._kind(), "a whole number")
        if (low is not None and self.value < low) or (high is not None and self.value > high):
            self.fail(str(self.value)[:40], f"a number from {low} to {high}")
        return self.value

    def number(self) -> float:
        """A finite number."""
        if isinstance(self.value, bool) or not isinstance(self.value, int | float):
            self.fail(self._kind(), "a number")
        if (isinstance(self.value, int) and abs(self.value) > 2**1000) or not math.isfinite(self.value):
            self.fail("not finite", "a finite number")
        return float(self.value)

    def array(self, *shape: int | None) -> Float[np.ndarray, "..."]:
        """Nested lists of finite numbers of this shape; None stands for any length."""
        if not shape:
            return np.array(self.number())
        rows = [row.array(*shape[1:]) for row in self.items()]
        if shape[0] is not None and len(rows) != shape[0]:
            self.fail(f"a list of {len(rows)}", f"a list of {shape[0]}")
        rest = tuple(length or 0 for length in shape[1:])
        return np.array(rows, dtype=np.float64) if rows else np.empty((0, *rest))

    def mapping(self) -> dict[str, Any]:
        """An object, unchecked inside."""
        if not isinstance(self.value, dict):
            self.fail(self._kind(), "an object")
        return self.value

    def _below(self, key: str) -> str:
        return f"{self.path}.{key}" if self.path else key

    def _kind(self) -> str:
        kinds = {dict: "an object", list: "a list", str: "a string", bool: "true or false"}
        return "null" if self.value is None else kinds.get(type(self.value), "a number")


def read_json(path: Path) -> JsonNode:
    """The document in a UTF-8 file.

    Raises:
        InputError: the file cannot be read or is no JSON.
    """
    if path.is_dir():
        raise InputError(
            f"{path.name}: is a directory; a JSON file is needed. Fix: name the file, e.g. its model.json."
        )
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as e:
        raise InputError(f"{path.name}: cannot be read: {e.strerror}. Fix: check the path.") from e
    except UnicodeDecodeError as e:
        raise InputError(
            f"{path.name}: is not UTF-8 text; a JSON file is needed. Fix: name the file, e.g. its model.json."
        ) from e
    try:
        return JsonNode(json.loads(text), path.name)
    except (ValueError, RecursionError) as e:
        raise InputError(
            f"{path.name}: is not JSON: {str(e)[:120]}. Fix: repair the file or write it again."
        ) from e
