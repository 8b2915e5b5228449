"""Elements of a MATLAB file of level 5: checked ahead of a reader that trusts their types.

A file is a header of 128 bytes and data elements, each a tag (type, number of bytes) and its data, padded to 8 bytes.
An element of up to 4 bytes may share the 8 bytes of its tag. An array is an element of elements (MathWorks, MAT-File
Format, section 1).
"""

import struct
import zlib
from collections.abc import Iterator, Sequence
from math import prod
from pathlib import Path

from imugap.log import LogError

HEADER, TAG = 128, 8
INT8, INT32, UINT32, ARRAY, COMPRESSED = 1, 5, 6, 14, 15
NUMBERS = frozenset((1, 2, 3, 4, 5, 6, 7, 9, 12, 13))
TEXTS = NUMBERS | {16, 17, 18}
"""Types of numbers, and of texts."""
CELLS, STRUCTURE, OBJECT, TEXT, SPARSE, LAST_OF_NUMBERS = 1, 2, 3, 4, 5, 15
"""Classes of arrays. Those up to the last hold what their class says; later ones hold texts and arrays."""
CLASS, COMPLEX = 0xFF, 0x800
"""Class among the flags of an array, and the flag of an imaginary part."""
HEADS = {CELLS: (), STRUCTURE: (INT32, INT8), OBJECT: (INT8, INT32, INT8)}
"""Types of the elements ahead of the arrays in an array of arrays."""
FEWEST, MOST = 2, 32
"""Numbers of dimensions of an array."""
DEEPEST = 100
"""Largest number of arrays within each other."""


def require_sound(path: Path) -> None:
    """Raise a LogError unless every element has a type of the format and lies within the one around it."""
    content = path.read_bytes()
    order = "<" if content[HEADER - 2 : HEADER] == b"IM" else ">"
    try:
        for kind, data in _elements(memoryview(content)[HEADER:], order):
            if kind == COMPRESSED:
                for inner in _elements(memoryview(zlib.decompress(data)), order):
                    _require_array(*inner, order, 0)
            else:
                _require_array(kind, data, order, 0)
    except (ValueError, zlib.error) as error:
        raise LogError(path, "file", "a sound MATLAB file of level 5", str(error)) from None


def _require_array(kind: int, data: memoryview, order: str, depth: int) -> None:
    """Raise a ValueError unless an element is an array with the elements of its class."""
    if kind != ARRAY or depth > DEEPEST:
        raise ValueError(f"an element of type {kind} in the place of an array, {depth} deep")
    inner = list(_elements(data, order))
    if not inner:
        return
    (first, word), *parts = inner
    if first != UINT32 or len(word) != TAG:
        raise ValueError(f"an element of type {first} in the place of the flags of an array")
    flags = struct.unpack_from(order + "I", word)[0]
    if flags & CLASS <= LAST_OF_NUMBERS:
        _require_parts(flags, parts, order, depth)
        return
    for one, part in parts:
        if one not in TEXTS:
            _require_array(one, part, order, depth + 1)


def _require_parts(flags: int, parts: Sequence[tuple[int, memoryview]], order: str, depth: int) -> None:
    """Raise a ValueError unless an array has the elements behind its flags that its class and dimensions need."""
    of = flags & CLASS
    types = (INT32, INT8, *HEADS.get(of, ()))
    heads, rest = [part for _, part in parts[: len(types)]], parts[len(types) :]
    if tuple(one for one, _ in parts[: len(types)]) != types:
        raise ValueError(f"other elements than those of an array of class {of}")
    dimensions = _integers(heads[0], order)
    if not FEWEST <= len(dimensions) <= MOST or min(dimensions) < 0:
        raise ValueError(f"an array of {len(heads[0])} bytes of dimensions")
    count = 3 if of == SPARSE else 1
    if of in HEADS:
        fields = 1 if of == CELLS else len(heads[-1]) // max((1, *_integers(heads[-2], order)))
        count = prod(dimensions) * fields
    elif flags & COMPLEX:
        count += 1
    if len(rest) != count:
        raise ValueError(f"{len(rest)} parts of an array of {count}")
    for one, part in rest:
        if of in HEADS:
            _require_array(one, part, order, depth + 1)
        elif one not in (TEXTS if of == TEXT else NUMBERS):
            raise ValueError(f"an element of type {one} in an array of class {of}")


def _integers(data: memoryview, order: str) -> tuple[int, ...]:
    """Return the whole numbers of 4 bytes in an element; none where it holds others."""
    return () if len(data) % 4 else struct.unpack_from(f"{order}{len(data) // 4}i", data)


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield type and data of each element; ValueError where one goes on beyond the end."""
    at = 0
    while at + TAG <= len(data):
        kind, size = struct.unpack_from(order + "II", data, at)
        if kind >> 16:
            kind, size, begin, end = kind & 0xFFFF, kind >> 16, at + 4, at + TAG
        else:
            begin = at + TAG
            end = begin + size + (0 if kind == COMPRESSED else -size % TAG)
        if begin + size > len(data):
            raise ValueError(f"an element of {size} bytes where {len(data) - begin} are left")
        yield kind, data[begin : begin + size]
        at = end
