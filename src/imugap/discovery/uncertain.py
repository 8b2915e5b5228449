"""An error model with what its fits leave open, as an ensemble of models."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from imugap.discovery.axis import AxisFit
from imugap.discovery.noise import limits
from imugap.effects.effect import Effect
from imugap.model import AxisModel, ErrorModel


@dataclass(frozen=True, eq=False)
class Uncertain:
    """An error model whose adjusted parameters have the uncertainty of their fits.

    Attributes
    ----------
    model
        The model.
    fits
        Axis to the fit that effects of its model come from; an effect that is in no fit is certain.
    """

    model: ErrorModel
    fits: Mapping[str, AxisFit] = field(default_factory=dict)

    def draw(self, rng: np.random.Generator) -> ErrorModel:
        """Draw a model: terms under their covariance, logarithms of the noise's parameters under its information."""
        axes = {}
        for axis, model in self.model.axes.items():
            drawn = _drawn(self.fits[axis], rng) if axis in self.fits else {}
            axes[axis] = AxisModel(tuple(drawn.get(effect, effect) for effect in model))
        return ErrorModel(axes)


def _drawn(fit: AxisFit, rng: np.random.Generator) -> dict[Effect, Effect]:
    """Return each adjusted effect of a fit with the drawn one in its place."""
    description = fit.description
    found, first = {}, 0
    steps = _normal(fit.covariance, rng)
    for term in description.terms:
        found[term.effect] = term.moved(steps[first : first + len(term.free)]).effect
        first += len(term.free)
    theta = np.clip(description.noise.theta() + _normal(fit.noise.covariance, rng), *_limits(fit))
    return found | dict(zip(description.noise, description.noise.at(theta), strict=True))


def _limits(fit: AxisFit) -> tuple[np.ndarray, np.ndarray]:
    """Return the limits that the logarithms of the noise's parameters had in the fit."""
    bins, noise = fit.sequence.bins, fit.description.noise
    return limits(noise, bins, bins.sums(fit.coefficients**2) * noise.variance(bins))


def _normal(covariance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw normal values of mean zero; covariances may be singular or of no values at all."""
    values, vectors = np.linalg.eigh(covariance)
    return vectors @ (np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(len(values)))
