"""A long command shows on a terminal that it runs, and nowhere else."""

import io
from contextlib import contextmanager, redirect_stderr, redirect_stdout
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


@contextmanager
def shown(title, **times):
    """Run a block whose outputs are a terminal."""
    terminal = Terminal()
    with redirect_stdout(terminal), redirect_stderr(terminal), elapsed.shown(title, **times):
        yield terminal


def test_a_long_block_shows_its_time_and_clears_it_at_the_end():
    with shown("imugap estimate", patience_s=0.0, interval_s=0.01) as terminal:
        assert terminal.written.wait(60)
    assert terminal.getvalue().startswith(f"{elapsed.CLEAR}imugap estimate: 0 s")
    assert terminal.getvalue().endswith(elapsed.CLEAR)


def test_what_is_printed_stands_in_a_line_of_its_own():
    with shown("imugap estimate", patience_s=0.0, interval_s=1e6) as terminal:
        assert terminal.written.wait(60)
        print("fits")
    assert terminal.getvalue() == f"{elapsed.CLEAR}imugap estimate: 0 s{elapsed.CLEAR}fits\n"


def test_a_block_that_fails_clears_it_too():
    def fail():
        with shown("imugap", patience_s=0.0, interval_s=1e6) as terminal:
            seen.append(terminal)
            terminal.written.wait(60)
            raise ValueError("bad")

    seen = []
    with pytest.raises(ValueError, match="bad"):
        fail()
    assert seen[0].getvalue().endswith(elapsed.CLEAR)


def test_a_short_block_shows_nothing():
    with shown("imugap check", patience_s=1e6) as terminal:
        pass
    assert not terminal.getvalue()


def test_nothing_is_shown_where_there_is_no_terminal():
    text = io.StringIO()
    with redirect_stderr(text), elapsed.shown("imugap estimate", patience_s=0.0, interval_s=0.01):
        pass
    assert not text.getvalue()
