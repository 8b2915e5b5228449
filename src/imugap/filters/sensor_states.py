"""Sensor-error states of a filter, from an error model.

Every process of the library that has a state space is a sum of independent first-order states: a constant, a random
walk, a Gauss-Markov process. Flicker noise (:class:`imugap.effects.BiasInstability`) is approximated by a bank of
Gauss-Markov processes (:mod:`imugap.interchange.flicker_bank`), and power-law noise by the nearer of flicker noise and
random walk. A turn-on bias and a random walk of the same axis share a state (:mod:`imugap.interchange.augmentation`).
A fixed bias is compensated. Quantisation and a band of noise above zero frequency are left out, since their integral
does not grow; a band from zero on is white noise. Of the effects of the signal
chain only the scale factor can be a state: a Gauss-Markov process, or a constant.
"""

from dataclasses import dataclass, replace

import numpy as np

from imugap.effects import (
    BandNoise,
    Bias,
    BiasInstability,
    PowerLaw,
    Quantization,
    RandomWalk,
    StochasticEffect,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel, Effect
from imugap.interchange.augmentation import augmentation
from imugap.interchange.flicker_bank import bank
from imugap.log import ACCEL, AXES, GYRO
from imugap.model import ErrorModel

FLICKER_S = (1.0, 1000.0)
"""Range of averaging times over which flicker noise is approximated [s]."""
FLICKER_STATES = 3
"""Number of Gauss-Markov processes that replace flicker noise; the Allan deviation of the bank errs by at most 4 %."""
RECEIVER = ("fix_north", "fix_east", "fix_down")
"""Slow errors of the position of a receiver [m]; their numbers follow those of the axes of the device."""
RANDOM_WALK_EXPONENT = 1.5
"""Exponent of power-law noise from which on it is approximated by a random walk."""


@dataclass(frozen=True, eq=False)
class SensorStates:
    """Error states of the six axes.

    Attributes
    ----------
    axis
        Index of the axis of each state in :data:`imugap.log.AXES`, then in :data:`RECEIVER`; shape (states,).
    scale
        Whether the state is a scale-factor error and not an additive error, shape (states,).
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
        """Build the states from an error model.

        Parameters
        ----------
        model
            Error model of the device; an axis without a model has no error.
        scale_std
            Standard deviations of the scale factors of gyroscopes and accelerometers; 0: not a state.
        scale_s
            Correlation time of the scale factors [s].
        """
        rows, white, fixed = [], np.zeros(6), np.zeros(6)
        for number, axis in enumerate(AXES):
            own = model.axes.get(axis, AxisModel())
            space = augmentation(_finite_order(own))
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

    def with_receiver(self, std: tuple[float, float, float], correlation_s: float) -> "SensorStates":
        """Return the states with slow errors of the position of a receiver, Gauss-Markov processes.

        Parameters
        ----------
        std
            Standard deviations north, east, down [m]; 0: not a state.
        correlation_s
            Correlation time [s].
        """
        added = [len(AXES) + number for number, one in enumerate(std) if one > 0]
        variance = np.array([one**2 for one in std if one > 0])
        return replace(
            self,
            axis=np.append(self.axis, added).astype(np.int64),
            scale=np.append(self.scale, np.zeros(len(added), bool)),
            decay=np.append(self.decay, np.full(len(added), 1 / correlation_s)),
            driving_psd=np.append(self.driving_psd, 2 * variance / correlation_s),
            variance=np.append(self.variance, variance),
        )

    @property
    def names(self) -> list[str]:
        """Names of the states, such as ``gyro_x``, ``gyro_x_2``, ``gyro_x_scale`` and ``fix_north``."""
        names = []
        for number, scale in zip(self.axis, self.scale, strict=True):
            own = (*AXES, *RECEIVER)[number]
            base = f"{own}_scale" if scale else own
            names.append(base if base not in names else f"{base}_{sum(n.startswith(base) for n in names) + 1}")
        return names

    def __len__(self) -> int:
        """Return the number of states."""
        return len(self.axis)


def _finite_order(model: AxisModel) -> AxisModel:
    """Return the model without noise whose integral does not grow, the rest approximated by first-order states."""
    effects = []
    for effect in (one for one in model if not _is_bounded(one)):
        one = _nearest_process(effect) if isinstance(effect, PowerLaw | BandNoise) else effect
        flicker = isinstance(one, BiasInstability)
        effects += bank(one.density_b, *FLICKER_S, FLICKER_STATES) if flicker else [one]
    return AxisModel(tuple(effects))


def _is_bounded(effect: Effect) -> bool:
    """Return whether an effect is noise whose integral does not grow: it has no power at zero frequency."""
    return isinstance(effect, Quantization) or (isinstance(effect, BandNoise) and effect.edges[0] > 0)


def _nearest_process(law: PowerLaw | BandNoise) -> StochasticEffect:
    """Return the white noise, flicker noise or random walk that is nearest to noise of another spectrum.

    A band from zero frequency on is white noise of its density. Of power-law noise it is the process with the same
    Allan variance in the middle of :data:`FLICKER_S`, the geometric mean.
    """
    if isinstance(law, BandNoise):
        return WhiteNoise(law.density)
    tau = np.sqrt(np.prod(FLICKER_S))
    unit = BiasInstability(1.0) if law.exponent < RANDOM_WALK_EXPONENT else RandomWalk(1.0)
    size = float(np.sqrt(law.allan_variance(tau) / unit.allan_variance(tau)))
    return type(unit)(size)
