"""Clock of a device that goes faster or slower than that of the receiver, whose time is that of the satellites.

The stamps of the samples are corrected, about the first one, since their intervals are those of the integration.
"""

from dataclasses import replace

import pandas as pd

from imugap.log import TIME
from imugap.navigation.drive.correction import Correction
from imugap.navigation.drive.vehicle import DriveInputs

PPM = 1e-6


def with_clock(inputs: DriveInputs, rate: float, offset: float = 0.0) -> DriveInputs:
    """Return the inputs with the intervals of the samples longer by the share ``rate``, and a time offset added [s]."""
    time, known = inputs.log.index.to_numpy(dtype=float), inputs.assumptions
    stamps = pd.Index(time[0] + (1 + rate) * (time - time[0]), name=TIME)
    moved = replace(
        known, clock_rate=(1 + known.clock_rate) * (1 + rate) - 1, time_offset_s=known.time_offset_s + offset
    )
    return replace(inputs, log=inputs.log.set_axis(stamps), assumptions=moved)


def with_drift(inputs: DriveInputs, drift: float, offset: float) -> DriveInputs:
    """Return the inputs with a time offset of the fixes compensated that changes.

    Parameters
    ----------
    drift
        Change of the offset per time of the device.
    offset
        Offset at the first sample, in addition to that of the inputs [s].
    """
    return with_clock(inputs, -drift / (1 + drift), offset)


def as_logged(inputs: DriveInputs, time: pd.Index) -> pd.Index:
    """Return the stamps that the log had at a time of the corrected clock [s]."""
    begin = inputs.log.index[0]
    return pd.Index(begin + (time.to_numpy() - begin) / (1 + inputs.assumptions.clock_rate), name=TIME)


def clock_correction(inputs: DriveInputs, before: DriveInputs) -> Correction:
    """Return in words what was done about the clock."""
    used = inputs.assumptions
    rate = (1 + used.clock_rate) / (1 + before.assumptions.clock_rate) - 1
    pace = "faster" if rate < 0 else "slower"
    found = f"the stamps of the samples go {abs(rate) / PPM:.0f} ppm {pace} than those of the fixes"
    setting = f"time_offset: {{offset_s: {used.time_offset_s:.3f}, rate_ppm: {used.clock_rate / PPM:.0f}}}"
    return Correction("clock rate", found, setting)
