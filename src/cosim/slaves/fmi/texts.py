"""Strings and binaries of an FMU: read and written variable by variable, since they are few and never in an inner loop."""

import ctypes
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..signal import Text, Value
from .library import POINTER, REFERENCES, SIZE, Library
from .rows import Row
from .signals import by_variable, names


class Texts:
    """The functions for them; `check` raises for a bad status.

    prefix : of their names, "fmi", "fmi2" or "fmi3".
    """

    def __init__(self, library: Library, prefix: str, check: Callable[[int, str, float, float], None]) -> None:
        self._library, self._prefix, self._check = library, prefix, check

    def _function(self, direction: str, row: Row) -> Any:
        kinds = [POINTER, REFERENCES, SIZE, POINTER]
        kinds += [] if self._prefix != "fmi3" else [SIZE] if row.type == "String" else [POINTER, SIZE]
        return self._library.function(f"{self._prefix}{direction}{row.type}", *kinds)

    def read(self, instance: Any, row: Row, t: float) -> list[Text]:
        """The values of its elements at t (s); a string that is no UTF-8 keeps its bytes."""
        n, reference = row.size, (ctypes.c_uint * 1)(row.reference)
        get = self._function("Get", row)
        if row.type == "Binary":
            sizes, blocks = (SIZE * n)(), (POINTER * n)()
            status = get(instance, reference, 1, sizes, blocks, n)
            self._check(status, f"{self._prefix}GetBinary of {row.name!r}", t, 0.0)
            return [ctypes.string_at(block, size) if size else b"" for block, size in zip(blocks, sizes, strict=True)]
        texts = (ctypes.c_char_p * n)()
        status = get(instance, reference, 1, texts, *(() if self._prefix != "fmi3" else (n,)))
        self._check(status, f"{self._prefix}GetString of {row.name!r}", t, 0.0)
        return [(text or b"").decode(errors="surrogateescape") for text in texts]

    def write(self, instance: Any, row: Row, values: Sequence[Value], t: float) -> None:
        """Give its elements their values at t (s)."""
        n, reference = len(values), (ctypes.c_uint * 1)(row.reference)
        set_ = self._function("Set", row)
        if row.type == "Binary":
            blocks = [value if isinstance(value, bytes) else b"" for value in values]
            status = set_(instance, reference, 1, (SIZE * n)(*map(len, blocks)), (ctypes.c_char_p * n)(*blocks), n)
        else:
            texts = (ctypes.c_char_p * n)(*(str(value).encode(errors="surrogateescape") for value in values))
            status = set_(instance, reference, 1, texts, *(() if self._prefix != "fmi3" else (n,)))
        self._check(status, f"{self._prefix}Set{row.type} of {row.name!r}", t, 0.0)


def changed_texts(
    rows: Mapping[str, Row], before: Mapping[str, Text], given: Mapping[str, Text]
) -> tuple[list[tuple[Row, list[Value]]], tuple[tuple[str, Text], ...]]:
    """The variables to be written, whole, since `given` has other texts than `before`; and all texts that then hold."""
    changed = {name for name, text in given.items() if before.get(name) != text}
    after = {**before, **given}
    found = [(row, values) for row, values in by_variable(rows, after) if changed & set(names(row))]
    return found, tuple(sorted(after.items()))
