"""Atomic writing of files: completely or not at all."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path to write to; rename it to ``path`` if the block succeeds, remove it if it fails."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + ".partial")
    try:
        yield partial
        partial.rename(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def write_together(writers: Mapping[str | Path, Callable[[Path], object]]) -> None:
    """Write several files, or none if one of them fails; each writer gets a temporary path."""
    with ExitStack() as stack:
        for path, write in writers.items():
            write(stack.enter_context(atomic(path)))
