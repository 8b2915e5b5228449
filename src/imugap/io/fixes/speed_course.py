"""Fixes as phones state them: speed and course over ground, and radii that hold the truth in 68 % of cases.

The radius of a horizontal place with independent normal errors of one size holds 68 % of them at 1.51 standard
deviations; of a height or a speed it is one. What a phone does not know is below zero.

Sources: documentation of ``android.location.Location`` (accuracies at 68 %) and of ``CLLocation`` of Core Location
(negative where invalid).
"""

from itertools import pairwise

import numpy as np
import pandas as pd

from imugap.io.fixes import fix_units
from imugap.io.gnss import PLACE_STD, VELOCITY_STD
from imugap.kinematics.strapdown import VELOCITY
from imugap.numerics.samples.chi_square import squared_radius

SPEED, COURSE, RADIUS, HEIGHT_STD, SPEED_STD = "speed", "course", "radius", "sd_height", "sd_speed"
COLUMNS = (SPEED, COURSE, RADIUS, HEIGHT_STD, SPEED_STD)
SIGMAS = float(np.sqrt(squared_radius(0.68)))
"""Radius that holds 68 % of the horizontal errors, in standard deviations of a component."""
SLOWEST = 2.0
"""Mean speed by the places from which on these tell the unit of a speed [m/s]."""
UNIT_SHARE = 0.07
"""Largest difference of a speed from that by the places, as a share, in a unit that is taken."""
UNITS = ("m/s", "km/h", "kn", "mph")
"""Units of a speed over ground."""
AT_REST = 0.1
"""Speed below which a course that is not known does not matter [m/s]."""


def with_components(table: pd.DataFrame, stated: str | None) -> tuple[pd.DataFrame, list[str]]:
    """Return fixes with components in the place of :data:`COLUMNS`, and what was done.

    Parameters
    ----------
    table
        Index ``time`` [s]; places in degrees, course in degrees, lengths in metres, speeds in ``stated``.
    stated
        Unit of the speed by its header, which is converted already, or None.
    """
    given = {name: table[name] for name in COLUMNS if name in table}
    rest, notes = table.drop(columns=list(given)), []
    known = {name: one.where(one >= 0) for name, one in given.items()}
    if RADIUS in known and PLACE_STD[0] not in rest:
        across = (known[RADIUS] / SIGMAS).where(known[RADIUS] > 0)
        down = known.get(HEIGHT_STD, known[RADIUS])
        rest = rest.assign(**dict(zip(PLACE_STD, (across, across, down.where(down > 0)), strict=True)))
        notes.append("standard deviations from the accuracy, a radius of 68 %")
    if not {SPEED, COURSE} <= set(known) or VELOCITY[0] in rest:
        return rest, notes
    unit = stated or _unit(table, known[SPEED])
    if unit is None:
        return rest, [*notes, "left out the speed, which is that of the places in no unit"]
    speed, course = known[SPEED] * (1.0 if stated else fix_units.SPEEDS[unit]), np.radians(known[COURSE])
    course = course.where(~(course.isna() & (speed < AT_REST)), 0.0)
    rest = rest.assign(**dict(zip(VELOCITY, (speed * np.cos(course), speed * np.sin(course), np.nan), strict=True)))
    if SPEED_STD in known:
        rest = rest.assign(**dict.fromkeys(VELOCITY_STD, known[SPEED_STD].where(known[SPEED_STD] > 0)))
    said = "" if unit == "m/s" else f", {unit} -> m/s from the places"
    return rest, [*notes, f"velocity from speed and course{said}"]


def _unit(table: pd.DataFrame, speed: pd.Series) -> str | None:
    """Return the unit of a speed by that of the places; m/s where these hardly move, None where no unit fits."""
    time = table.index.to_numpy(dtype=float)
    latitude, longitude = (np.radians(table[name].to_numpy()) for name in ("latitude", "longitude"))
    places = np.column_stack([latitude, longitude * np.cos(np.nanmedian(latitude))]) * fix_units.EARTH_M
    rows = np.unique(np.searchsorted(time, np.arange(time[0], time[-1], fix_units.SPANS_S[0])))
    implied = [
        (np.hypot(*(places[last] - places[first])) / (time[last] - time[first]), speed.iloc[first : last + 1].mean())
        for first, last in pairwise(rows)
    ]
    moving = [one for one in implied if one[0] > SLOWEST and np.isfinite(one[1])]
    if len(moving) < len(implied) / 10 or not moving:
        return "m/s"
    ratio = float(np.median([speed_read / by_places for by_places, speed_read in moving]))
    best = min(UNITS, key=lambda unit: abs(np.log(ratio * fix_units.SPEEDS[unit])))
    return best if abs(np.log(ratio * fix_units.SPEEDS[best])) < UNIT_SHARE else None
