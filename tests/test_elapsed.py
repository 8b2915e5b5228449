"""A long command shows on a terminal that it runs, and nowhere else."""

import io
import sys
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


@pytest.fixture
def terminal(monkeypatch):
    one = Terminal()
    monkeypatch.setattr(sys, "stderr", one)
    monkeypatch.setattr(sys, "stdout", one)
    return one


def test_a_long_block_shows_its_time_and_clears_it_at_the_end(terminal):
    with elapsed.shown("imugap estimate", patience_s=0.0, interval_s=0.01):
        assert terminal.written.wait(60)
    assert terminal.getvalue().startswith(f"{elapsed.CLEAR}imugap estimate: 0 s")
    assert terminal.getvalue().endswith(elapsed.CLEAR)


def test_what_is_printed_stands_in_a_line_of_its_own(terminal):
    with elapsed.shown("imugap estimate", patience_s=0.0, interval_s=1e6):
        assert terminal.written.wait(60)
        print("fits")
    assert terminal.getvalue() == f"{elapsed.CLEAR}imugap estimate: 0 s{elapsed.CLEAR}fits\n"


def test_a_block_that_fails_clears_it_too(terminal):
    def fail():
        with elapsed.shown("imugap", patience_s=0.0, interval_s=1e6):
            terminal.written.wait(60)
            raise ValueError("bad")

    with pytest.raises(ValueError, match="bad"):
        fail()
    assert terminal.getvalue().endswith(elapsed.CLEAR)


def test_a_short_block_shows_nothing(terminal):
    with elapsed.shown("imugap check", patience_s=1e6):
        pass
    assert not terminal.getvalue()


def test_nothing_is_shown_where_there_is_no_terminal(monkeypatch):
    text = io.StringIO()
    monkeypatch.setattr(sys, "stderr", text)
    with elapsed.shown("imugap estimate", patience_s=0.0, interval_s=0.01):
        pass
    assert not text.getvalue()
