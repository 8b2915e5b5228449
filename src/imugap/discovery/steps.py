"""Steps of discovery: their count, and tasks of several axes in several processes."""

import ctypes
import multiprocessing
import os
import signal
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from threading import Thread
from time import sleep
from typing import TypeVar

Made = TypeVar("Made")
Progress = Callable[[str, int, int], None]
"""Called with the name of a step as it begins, how many steps are done, and how many there are."""


def no_progress(step: str, done: int, steps: int) -> None:
    """Report no progress."""


PR_SET_PDEATHSIG = 1
"""Argument of prctl(2): the signal that a process gets when its parent ends."""
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that ask a process to end."""
WATCH_S = 0.5
"""Time between two looks at the parent of a worker process [s]."""


@dataclass
class StepCounter:
    """Counter of the steps as they begin."""

    progress: Progress
    count: int
    done: int = 0

    def begin(self, name: str) -> None:
        """Report that a step begins."""
        self.progress(name, self.done, self.count)
        self.done += 1


@dataclass(frozen=True, eq=False)
class Memory:
    """Results by what they were made of, for steps that are repeated with some axes as they were."""

    made: dict[Hashable, object] = field(default_factory=dict)

    def once(self, make: Callable[..., Made], *of: Hashable) -> Made:
        """Return ``make(*of)``, made at the first call."""
        if (make, *of) not in self.made:
            self.made[make, *of] = make(*of)
        return self.made[make, *of]


@contextmanager
def each_in_processes(workers: int) -> Iterator[Callable]:
    """Yield a ``map`` that runs in some processes; the built-in one for a single process.

    The processes end with the block, at once if it fails, and with their parent, however that ends.
    """
    if workers == 1:
        yield map
        return
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(workers, initializer=_depend_on, initargs=(os.getpid(),))
    try:
        with _held_signals():
            pool.submit(int)  # starts the processes
        yield pool.map
        pool.shutdown()
    except BaseException:
        for process in set(multiprocessing.active_children()) - others:  # else the pool waits for what they are at
            process.terminate()
        pool.shutdown(cancel_futures=True)  # ends its thread, which must not outlive the interpreter
        raise


@contextmanager
def _held_signals() -> Iterator[None]:
    """Hold back the signals that end a process; a process that starts in the block does so until :func:`_depend_on`."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _depend_on(parent: int) -> None:
    """Have a worker process leave signals of the terminal to its parent, and end when the parent does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    with suppress(AttributeError):  # Linux alone has it; at once, also within a long call of compiled code
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    """End this process once ``parent`` is no more its parent."""
    while os.getppid() == parent:
        sleep(WATCH_S)
    os._exit(1)


def of_each_axis(
    task: Callable, arguments: Sequence[tuple], axes: Iterable[str], workers: int, steps: StepCounter, step: str
) -> dict:
    """Return the result of a task for the arguments of each axis, several axes at a time."""
    found = {}
    if not arguments:
        return found
    with each_in_processes(workers) as each:
        results = iter(each(task, *zip(*arguments, strict=True)))
        for axis in axes:
            steps.begin(step)
            found[axis] = next(results)
    return found
