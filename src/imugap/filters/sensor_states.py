"""What a filter holds of the errors of its sensors: the states of an error model, each of them on one axis.

Every process of the library that has a state space is a sum of independent first-order states: a constant, a random
walk, a Gauss-Markov process. Flicker noise (:class:`imugap.effects.BiasInstability`), which has none, is taken for the
nearest bank of Gauss-Markov processes over a stated range of averaging times (:mod:`imugap.interchange.flicker_bank`),
and noise of any slope for the flicker noise or random walk that is nearer. A turn-on bias and a random walk of the same
axis share a state (:mod:`imugap.interchange.augmentation`). The fixed bias is compensated as it stands. Quantisation is
left out, since its integral does not grow; of the effects of the signal chain the filter knows nothing but the scale
factor, if it is told to estimate it: a Gauss-Markov process, or a constant.
"""

from dataclasses import dataclass

import numpy as np

from imugap.effects import Bias, BiasInstability, PowerLaw, Quantization, RandomWalk, StochasticEffect
from imugap.effects.effect import AxisModel
from imugap.interchange.augmentation import augmentation
from imugap.interchange.flicker_bank import bank
from imugap.log import ACCEL, AXES, GYRO
from imugap.model import ErrorModel

FLICKER_S = (1.0, 1000.0)
"""Range of averaging times over which flicker noise is approximated [s]."""
FLICKER_STATES = 3
"""Gauss-Markov processes in its place; their Allan deviation errs by 4 % at most over the range."""
NEARER = 1.5
"""Exponent of noise of any slope from which on a random walk is nearer."""


@dataclass(frozen=True, eq=False)
class SensorStates:
    """States of the errors of six axes.

    Attributes
    ----------
    axis
        Number of the axis of each state in :data:`imugap.log.AXES`, shape (states,).
    scale
        Whether the state is the error of a scale factor and not of the output itself, shape (states,).
    decay
        One over the correlation time, 0 for a constant or a random walk [1/s], shape (states,).
    driving_psd
        Two-sided PSD of the noise that drives the state, shape (states,).
    variance
        Variance at the start, shape (states,).
    white
        Two-sided PSD of the white noise of each axis, shape (6,).
    fixed
        Fixed bias of each axis, shape (6,).
    """

    axis: np.ndarray
    scale: np.ndarray
    decay: np.ndarray
    driving_psd: np.ndarray
    variance: np.ndarray
    white: np.ndarray
    fixed: np.ndarray

    @classmethod
    def of(
        cls, model: ErrorModel, scale_std: tuple[float, float] = (0.0, 0.0), scale_s: float = np.inf
    ) -> "SensorStates":
        """Take the states from an error model.

        Parameters
        ----------
        model
            The model of the device; an axis without one has no error.
        scale_std
            Standard deviations of the scale factors of gyroscopes and accelerometers; where above zero they are states.
        scale_s
            Correlation time of the scale factors [s].
        """
        rows, white, fixed = [], np.zeros(6), np.zeros(6)
        for number, axis in enumerate(AXES):
            own = model.axes.get(axis, AxisModel())
            space = augmentation(_finite(own))
            if np.any(space.dynamics != np.diag(np.diag(space.dynamics))) or np.any(space.output != 1):
                raise ValueError(f"{axis}: expected first-order processes; found coupled states")
            states = np.column_stack([np.diag(one) for one in (-space.dynamics, space.process_psd)])
            start = np.diag(space.initial_covariance)
            rows += [(number, False, *state, first) for state, first in zip(states, start, strict=True)]
            white[number] = space.output_psd
            fixed[number] = sum(effect.value for effect in own if isinstance(effect, Bias))
        for std, triad in zip(scale_std, (GYRO, ACCEL), strict=True):
            driving = 2 * std**2 / scale_s
            rows += [(AXES.index(axis), True, 1 / scale_s, driving, std**2) for axis in triad if std > 0]
        kinds = np.int64, bool, float, float, float
        columns = zip(*rows, strict=True) if rows else ((),) * len(kinds)
        return cls(*(np.array(column, kind) for column, kind in zip(columns, kinds, strict=True)), white, fixed)

    @property
    def names(self) -> list[str]:
        """Names of the states: the axis, for a further state of it with a number, for a scale factor with its word."""
        names = []
        for number, scale in zip(self.axis, self.scale, strict=True):
            base = f"{AXES[number]}_scale" if scale else AXES[number]
            names.append(base if base not in names else f"{base}_{sum(n.startswith(base) for n in names) + 1}")
        return names

    def __len__(self) -> int:
        """Return the number of states."""
        return len(self.axis)


def _finite(model: AxisModel) -> AxisModel:
    """Return the model without quantisation, and with what has no finite order approximated by processes that have."""
    effects = []
    for effect in (one for one in model if not isinstance(one, Quantization)):
        one = _named(effect) if isinstance(effect, PowerLaw) else effect
        flicker = isinstance(one, BiasInstability)
        effects += bank(one.density_b, *FLICKER_S, FLICKER_STATES) if flicker else [one]
    return AxisModel(tuple(effects))


def _named(law: PowerLaw) -> StochasticEffect:
    """Return the flicker noise or the random walk, whichever slope is nearer, of the same Allan variance at its middle.

    That is the middle of the averaging times over which flicker noise is approximated.
    """
    tau = np.sqrt(np.prod(FLICKER_S))
    unit = BiasInstability(1.0) if law.exponent < NEARER else RandomWalk(1.0)
    size = float(np.sqrt(law.allan_variance(tau) / unit.allan_variance(tau)))
    return type(unit)(size)
