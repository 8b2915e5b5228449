"""Rate of the course by fixes, which the gyroscopes of a vehicle measure as well."""

import numpy as np
import pandas as pd

from imugap.io import gnss

SLOWEST = 3.0
"""Speed below which a course says little [m/s]."""
QUANTILE = 0.9
FEWEST = 20


def fast_course_rate(fixes: pd.DataFrame) -> float | None:
    """Return the rate of the course that one fix in ten exceeds in motion [rad/s]; None where there are too few."""
    time = fixes.index.to_numpy()
    place = gnss.local(fixes, gnss.origin(fixes))
    velocity = place[:, 3:5] if np.isfinite(place[:, 3:5]).all() else np.gradient(place[:, :2], time, axis=0)
    course = np.unwrap(np.arctan2(velocity[:, 1], velocity[:, 0]))
    fast = np.hypot(*velocity.T) > SLOWEST
    steps, both = np.diff(time), fast[1:] & fast[:-1]
    rates = np.abs(np.diff(course) / steps)[both & (steps < 3 * np.median(steps))]
    return float(np.quantile(rates, QUANTILE)) if len(rates) >= FEWEST else None
