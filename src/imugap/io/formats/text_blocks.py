"""Blocks of whole lines of a text, as UTF-8, in the memory of a block."""

import codecs
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

BLOCK_BYTES = 1 << 20


def blocks(path: Path, encoding: str, end: int) -> Iterator[bytes]:
    """Yield the lines of a text up to an end, many together; the last one alone may lack its line end.

    Bytes that are no UTF-8 are replaced by a mark, which is in no number; those that are no text in another encoding
    are a UnicodeDecodeError.

    Parameters
    ----------
    encoding
        ``utf-8``, with or without a mark at the begin, or any other.
    end
        Number of bytes that are read.
    """
    encoded = encoding.startswith("utf-8")
    parts = _parts(path, end) if encoded else _decoded(_parts(path, end), encoding)
    rest = b""
    for part in parts:
        whole, ending, begun = part.rpartition(b"\n")
        if ending:
            yield _sound(rest + whole + ending)
            rest = begun
        else:
            rest += begun
    if rest:
        yield _sound(rest)


def _parts(path: Path, end: int) -> Iterator[bytes]:
    """Yield the bytes of a file up to an end."""
    with path.open("rb") as handle:
        while end > 0 and (part := handle.read(min(BLOCK_BYTES, end))):
            end -= len(part)
            yield part


def _decoded(parts: Iterator[bytes], encoding: str) -> Iterator[bytes]:
    """Yield a text in another encoding as UTF-8; a character may begin in one part and end in the next."""
    decoder = codecs.getincrementaldecoder(encoding)()
    for part in chain(parts, [b""]):
        yield decoder.decode(part, final=not part).encode()


def _sound(block: bytes) -> bytes:
    return block if block.isascii() else block.decode(errors="replace").encode()
