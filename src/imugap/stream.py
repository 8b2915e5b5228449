"""Named random streams: the same seed and labels give the same numbers, independent of other streams."""

from zlib import crc32

import numpy as np


def stream(seed: int, *labels: object) -> np.random.Generator:
    """Return the random generator of ``seed`` and ``labels``.

    A label is identified by its text, so ``stream(1, "run", 2)`` and ``stream(1, "run", "2")`` are the same stream.
    Labels are encoded one by one: ``("ab", "c")`` and ``("a", "bc")`` differ, and so do ``("a",)`` and ``("a", "")``.
    """
    encoded = [word for label in labels for word in words(str(label))]
    return np.random.default_rng([seed, len(labels), *encoded])


def words(text: str) -> tuple[int, int]:
    """Return the checksum and the length of ``text``, by which a label is known."""
    data = text.encode()
    return crc32(data), len(data)
