"""Size of a known effect in the logs of a device, for the test that knows it and the noise."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from imu_benchmark.sealing.detection_limits import Z
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.prepare import prepare
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.effect import Effect, Role
from imugap.log import TEMPERATURE


def sizes_in_limits(logs: Sequence[pd.DataFrame], axis: str, effects: Sequence[Effect], known: Effect) -> np.ndarray:
    """Return the size of an effect of the mean in each log, in detection limits, shape (logs,).

    A size is the root of the deflection of the matched filter beside the true noise, over the quantile of the normal
    law of a one-sided test at 1 % (Neyman & Pearson 1933, Phil. Trans. R. Soc. A 231): at size 1 the most powerful test
    has a power of one half. Of several logs with independent noise the squares of the sizes add up.

    Parameters
    ----------
    logs
        Logs of a device at rest, with all that the effect depends on.
    axis
        Axis of the effect.
    effects
        True effects of the axis; the random processes among them are its noise.
    known
        The effect, with its true values.
    """
    noise = Description.known(*(one for one in effects if one.role is Role.NOISE))
    columns = [name for name in logs[0] if name in (axis, TEMPERATURE)]
    return np.array([_deflection(prepare(log[columns]).sequences[axis], noise, known) for log in logs]) / Z


def _deflection(sequence: AxisSequence, noise: Description, known: Effect) -> float:
    """Return the size of an effect in standard deviations of its matched filter."""
    signal = known.sample(sequence.conditions, None)
    return float(np.linalg.norm(fit(sequence, noise).whiten(signal[:, None])))
