"""The sealed half of the blind benchmark: logs with something hidden in them, and the keys that say what.

Nothing here knows the effect classes, the error models or the state spaces of this package: signals are made by other
means (exact switching, fractional differencing, circulant embedding, cumulated sums, closed forms), so that a fault of
theirs is not repeated here and goes unseen.

A case is a folder of canonical logs (``log.parquet``, or ``run1.parquet`` to ``run5.parquet`` of one device), with
``reference.parquet`` where the device moves and ``model.yaml`` where the base device is more than bias and white noise.
Its key, in another folder, names kind, base and effects: name, axes, parameters [SI] and size in detection limits.
"""

from imugap.benchmark.sealing.case import Sealed, seal, write
from imugap.benchmark.sealing.plan import Case, Hides, Planned, plan

__all__ = ["Case", "Hides", "Planned", "Sealed", "plan", "seal", "write"]
