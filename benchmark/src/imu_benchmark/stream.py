"""Named random streams: the same seed and labels give the same numbers, independent of other streams."""

from zlib import crc32

import numpy as np


def stream(seed: int, *labels: object) -> np.random.Generator:
    """Return the random generator of ``seed`` and ``labels``, each of which is identified by its text."""
    encoded = [word for text in map(str, labels) for word in (crc32(text.encode()), len(text.encode()))]
    return np.random.default_rng([seed, len(labels), *encoded])
