"""Elapsed time of a long command, shown on a terminal while it runs."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread
from typing import TextIO

PATIENCE_S = 3.0
"""Time after which a command shows that it runs [s]."""
INTERVAL_S = 1.0
CLEAR = "\r\x1b[K"
"""Sequence that clears the line of a terminal."""


@contextmanager
def shown(
    title: str, stream: TextIO | None = None, patience_s: float = PATIENCE_S, interval_s: float = INTERVAL_S
) -> Iterator[None]:
    """Show title and elapsed time of the block in one line, renewed until its end and then cleared.

    Parameters
    ----------
    title
        What runs.
    stream
        Where it is shown, the standard error by default; nothing is where it is no terminal.
    patience_s, interval_s
        Time until it is first shown, and between renewals [s].
    """
    stream = sys.stderr if stream is None else stream
    if not stream.isatty():
        yield
        return
    began, ended = time.monotonic(), Event()

    def show() -> None:
        pause = patience_s
        while not ended.wait(pause):
            stream.write(f"{CLEAR}{title}: {time.monotonic() - began:.0f} s\r")  # a message replaces the line
            stream.flush()
            pause = interval_s

    thread = Thread(target=show, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        if time.monotonic() - began > patience_s:
            stream.write(CLEAR)
            stream.flush()
