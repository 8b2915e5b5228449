"""Keep compiled kernels of different versions of the library apart (see :func:`imugap.dependencies.digest`).

Property tests draw the same examples every time, and take the time that they take: the first call of a kernel compiles.
"""

import os
from pathlib import Path

from hypothesis import settings

from imugap.dependencies import digest

os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(__file__).parents[1] / ".pytest_cache" / "numba" / digest()))
settings.register_profile("derandomised", derandomize=True, deadline=None)
settings.load_profile("derandomised")
