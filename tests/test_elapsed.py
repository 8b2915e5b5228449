"""A long command shows on a terminal that it runs, and nowhere else."""

import io
from threading import Event

import pytest

from imugap import elapsed


class Terminal(io.StringIO):
    """Text that is a terminal, and says when something is written."""

    def __init__(self):
        super().__init__()
        self.written = Event()

    def isatty(self):
        return True

    def write(self, text):
        self.written.set()
        return super().write(text)


def test_a_long_block_shows_its_time_and_clears_it_at_the_end():
    terminal = Terminal()
    with elapsed.shown("imugap estimate", terminal, patience_s=0.0, interval_s=0.01):
        assert terminal.written.wait(60)
    assert terminal.getvalue().startswith(f"{elapsed.CLEAR}imugap estimate: 0 s\r")
    assert terminal.getvalue().endswith(elapsed.CLEAR)


def test_a_block_that_fails_clears_it_too():
    terminal = Terminal()
    with pytest.raises(ValueError, match="bad"), elapsed.shown("imugap", terminal, patience_s=0.0):
        terminal.written.wait(60)
        raise ValueError("bad")
    assert terminal.getvalue().endswith(elapsed.CLEAR)


def test_a_short_block_shows_nothing():
    terminal = Terminal()
    with elapsed.shown("imugap check", terminal, patience_s=1e6):
        pass
    assert not terminal.getvalue()


def test_nothing_is_shown_where_there_is_no_terminal():
    text = io.StringIO()
    with elapsed.shown("imugap estimate", text, patience_s=0.0, interval_s=0.01):
        pass
    assert not text.getvalue()
