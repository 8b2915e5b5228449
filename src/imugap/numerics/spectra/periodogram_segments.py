"""Segmentation of a periodogram into bands of constant power."""

from heapq import heappop, heappush

import numpy as np

PENALTY = 8.0
"""Gain of log-likelihood that a band needs, beside that for the number of places where it may be."""


def segments(power: np.ndarray, most: int) -> list[tuple[int, int]]:
    """Return bands of constant mean of squared independent normal values, as (first, stop), in order.

    Bands are divided where that gains most log-likelihood: an interval of another mean is sought among intervals of
    all lengths in powers of two, each half as far apart as it is long (seeded segmentation: Kovacs et al. 2023,
    Biometrika 110, 249-256), its ends are moved to where they fit best, and the parts are divided in their turn.

    Parameters
    ----------
    power
        Squared values, shape (n,), each of the mean of its band times chi-square with one degree of freedom.
    most
        Largest number of bands.
    """
    sums = np.r_[0.0, np.cumsum(power)]
    found, queue = [(0, len(power))], []
    _consider(sums, 0, len(power), queue)
    while queue and len(found) < most:
        _, (first, begin, end, stop) = heappop(queue)
        parts = [(a, b) for a, b in ((first, begin), (begin, end), (end, stop)) if a < b]
        found.remove((first, stop))
        found += parts
        for a, b in parts:
            _consider(sums, a, b, queue)
    return sorted(found)


def _consider(sums: np.ndarray, first: int, stop: int, queue: list) -> None:
    """Put the best division of a band into the queue if it gains enough."""
    gain, begin, end = _best(sums, first, stop)
    if gain > PENALTY + np.log(stop - first) * 2:
        heappush(queue, (-gain, (first, begin, end, stop)))


def _best(sums: np.ndarray, first: int, stop: int) -> tuple[float, int, int]:
    """Return the gain of the best interval within a band, its begin, and its end."""
    best, length = (0.0, first, stop), 1
    while length < stop - first:
        begins = np.arange(first, stop - length + 1, max(length // 2, 1))
        best = max(best, _largest(sums, first, stop, begins, begins + length))
        length *= 2
    _, begin, end = best
    reach = max((end - begin) // 2, 1)
    for _ in range(2):
        ends = np.arange(max(end - reach, begin + 1), min(end + reach, stop) + 1)
        best = max(best, _largest(sums, first, stop, np.full(len(ends), begin), ends))
        begins = np.arange(max(begin - reach, first), min(begin + reach, best[2] - 1) + 1)
        best = max(best, _largest(sums, first, stop, begins, np.full(len(begins), best[2])))
        _, begin, end = best
    return best


def _largest(sums: np.ndarray, first: int, stop: int, begins: np.ndarray, ends: np.ndarray) -> tuple[float, int, int]:
    """Return the largest gain of some intervals within a band, with its begin and end."""
    whole = _deviance(sums[stop] - sums[first], stop - first)
    inside = _deviance(sums[ends] - sums[begins], ends - begins)
    before = _deviance(sums[begins] - sums[first], begins - first)
    after = _deviance(sums[stop] - sums[ends], stop - ends)
    gains = whole - inside - before - after
    one = int(np.argmax(gains))
    return float(gains[one]), int(begins[one]), int(ends[one])


def _deviance(total: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Return the negative log-likelihood of values of one mean, up to a constant: n/2 log(total/n), 0 for none."""
    mean = np.maximum(total, np.finfo(float).tiny) / np.maximum(count, 1)
    return np.where(count > 0, count / 2 * np.log(mean), 0.0)
