"""Steps of discovery: their count, and tasks of several axes in several processes."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass

Progress = Callable[[str, int, int], None]
"""Called with the name of a step as it begins, how many steps are done, and how many there are."""


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


@contextmanager
def each_in_processes(workers: int) -> Iterator[Callable]:
    """Yield a ``map`` that runs in some processes; the built-in one for a single process."""
    if workers == 1:
        yield map
        return
    with ProcessPoolExecutor(workers) as pool:
        yield pool.map


def of_each_axis(
    task: Callable, arguments: Sequence[tuple], axes: Iterable[str], workers: int, steps: StepCounter, step: str
) -> dict:
    """Return the result of a task for the arguments of each axis, several axes at a time."""
    found = {}
    with each_in_processes(workers) as each:
        results = iter(each(task, *zip(*arguments, strict=True)))
        for axis in axes:
            steps.begin(step)
            found[axis] = next(results)
    return found
