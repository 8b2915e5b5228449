"""Keep compiled kernels of different versions of the library apart (see :func:`imugap.dependencies.digest`)."""

import os
from pathlib import Path

from imugap.dependencies import digest

os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(__file__).parents[1] / ".pytest_cache" / "numba" / digest()))
