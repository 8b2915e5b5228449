"""An error model with what its fits leave open, as an ensemble of models."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit, Description
from imugap.discovery.fit.whittle import limits
from imugap.effects.effect import AxisModel, Effect
from imugap.model import ErrorModel


@dataclass(frozen=True, eq=False)
class FitUncertainty:
    """What a fit leaves open of the effects that it adjusted.

    Attributes
    ----------
    description
        The effects.
    of_terms, of_noise
        Covariances of the terms' free parameters and of the logarithms of the noise's.
    limits
        Lowest and highest logarithms that the noise's parameters had in the fit.
    """

    description: Description
    of_terms: np.ndarray
    of_noise: np.ndarray
    limits: tuple[np.ndarray, np.ndarray]

    @classmethod
    def of(cls, fit: AxisFit) -> "FitUncertainty":
        """Return that of a fit."""
        own = fit.bare()
        ends = limits(fit.description.noise, fit.sequence.bins, own.power)
        return cls(fit.description, own.covariance, fit.noise.covariance, ends)

    def drawn(self, rng: np.random.Generator) -> dict[Effect, Effect]:
        """Return each adjusted effect with the drawn one in its place."""
        description = self.description
        found, first = {}, 0
        steps = _normal(self.of_terms, rng)
        for term in description.terms:
            found[term.effect] = term.moved(steps[first : first + len(term.free)]).effect
            first += len(term.free)
        theta = np.clip(description.noise.theta() + _normal(self.of_noise, rng), *self.limits)
        return found | dict(zip(description.noise, description.noise.at(theta), strict=True))


@dataclass(frozen=True, eq=False)
class UncertainModel:
    """An error model whose adjusted parameters have the uncertainty of their fits.

    Attributes
    ----------
    model
        The model.
    left
        Axis to what the fit leaves open that effects of its model come from; an effect that is in no fit is certain.
    """

    model: ErrorModel
    left: Mapping[str, FitUncertainty] = field(default_factory=dict)

    @classmethod
    def of(cls, model: ErrorModel, fits: Mapping[str, AxisFit]) -> "UncertainModel":
        """Return a model whose effects come from the fits of its axes."""
        return cls(model, {axis: FitUncertainty.of(found) for axis, found in fits.items()})

    def draw(self, rng: np.random.Generator) -> ErrorModel:
        """Draw a model: terms under their covariance, logarithms of the noise's parameters under its information."""
        axes = {}
        for axis, model in self.model.axes.items():
            drawn = self.left[axis].drawn(rng) if axis in self.left else {}
            axes[axis] = AxisModel(tuple(drawn.get(effect, effect) for effect in model))
        return ErrorModel(axes)


def _normal(covariance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw normal values of mean zero; covariances may be singular or of no values at all."""
    values, vectors = np.linalg.eigh(covariance)
    return vectors @ (np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(len(values)))
