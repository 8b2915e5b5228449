"""Site and heading of a static device, and its error-free reading."""

from dataclasses import dataclass
from math import cos, degrees, radians, sin

import numpy as np
import pandas as pd

from imugap.kinematics import earth
from imugap.log import AXES, from_samples


@dataclass(frozen=True)
class Site:
    """Position on the WGS-84 ellipsoid and heading of a level device there.

    Attributes
    ----------
    latitude, height
        Geodetic latitude [rad], ellipsoidal height [m].
    heading
        Heading of the x axis [rad], or None where it is not known. Without it the Earth rate cannot be
        separated from the bias of the gyroscopes, and is included in it.
    """

    latitude: float
    height: float
    heading: float | None = None

    @classmethod
    def from_mapping(cls, mapping: dict) -> "Site":
        """Build from ``latitude_deg``, ``height_m`` and, if known, ``heading_deg``."""
        heading = mapping.get("heading_deg")
        return cls(radians(mapping["latitude_deg"]), mapping["height_m"], None if heading is None else radians(heading))

    @property
    def gravity(self) -> float:
        """Return normal gravity [m/s^2]."""
        return earth.normal_gravity(self.latitude, self.height)

    def ideal(self) -> pd.Series:
        """Return the error-free reading of a level device at rest, per axis, SI (z down)."""
        rate = np.zeros(3)
        if self.heading is not None:
            north, _, down = earth.earth_rate_n(self.latitude)
            rate = np.array([north * cos(self.heading), -north * sin(self.heading), down])
        return pd.Series([*rate, 0.0, 0.0, -self.gravity], index=list(AXES))

    def rest(self, count: int, interval: float) -> pd.DataFrame:
        """Return the error-free log of ``count`` samples of a level device at rest, ``interval`` [s] apart."""
        return from_samples({axis: np.full(count, value) for axis, value in self.ideal().items()}, interval)

    def __str__(self) -> str:
        """Return the site in words."""
        heading = "unknown" if self.heading is None else f"{degrees(self.heading):g} deg"
        return f"latitude {degrees(self.latitude):g} deg, height {self.height:g} m, heading {heading}"
