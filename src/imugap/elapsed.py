"""Elapsed time of a long command, shown on a terminal while it runs."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from threading import Event, Lock, Thread
from typing import TextIO

PATIENCE_S = 3.0
"""Time after which a command shows that it runs [s]."""
INTERVAL_S = 1.0
CLEAR = "\r\x1b[K"
"""Sequence that clears the line of a terminal."""


class StatusLine:
    """Last line of a terminal, which holds a text until something else is written."""

    def __init__(self, terminal: TextIO) -> None:
        """Take a terminal; nothing is shown yet."""
        self._terminal, self._lock, self._shown = terminal, Lock(), False

    def show(self, text: str) -> None:
        """Show a text in the place of the one before."""
        with self._lock:
            self._terminal.write(f"{CLEAR}{text}")
            self._terminal.flush()
            self._shown = True

    def clear(self) -> None:
        """Clear the line if it holds a text."""
        with self._lock:
            if self._shown:
                self._terminal.write(CLEAR)
                self._terminal.flush()
            self._shown = False


class OutputAbove:
    """Stream that clears a status line before it writes."""

    def __init__(self, stream: TextIO, status: StatusLine) -> None:
        """Take the stream, and the line of the same terminal."""
        self._stream, self._status = stream, status

    def write(self, text: str) -> int:
        """Write a text."""
        self._status.clear()
        return self._stream.write(text)

    def __getattr__(self, name: str):
        """Return any other attribute of the stream."""
        return getattr(self._stream, name)


@contextmanager
def shown(title: str, patience_s: float = PATIENCE_S, interval_s: float = INTERVAL_S) -> Iterator[None]:
    """Show title and elapsed time of the block on the standard error, if it is a terminal, and clear them at its end.

    Parameters
    ----------
    title
        What runs.
    patience_s, interval_s
        Time until it is first shown, and between renewals [s].
    """
    if not sys.stderr.isatty():
        yield
        return
    began, ended, status = time.monotonic(), Event(), StatusLine(sys.stderr)

    def show() -> None:
        pause = patience_s
        while not ended.wait(pause):
            status.show(f"{title}: {time.monotonic() - began:.0f} s")
            pause = interval_s

    thread = Thread(target=show, daemon=True)
    thread.start()
    try:
        with redirect_stdout(OutputAbove(sys.stdout, status)), redirect_stderr(OutputAbove(sys.stderr, status)):
            yield
    finally:
        ended.set()
        thread.join()
        status.clear()
