"""Error models whose parameters are drawn from the uncertainty of their fits."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.description import Description
from imugap.discovery.fit.whittle import limits
from imugap.effects.effect import AxisModel, Effect
from imugap.model import ErrorModel


@dataclass(frozen=True, eq=False)
class FitUncertainty:
    """Uncertainty of the effects that a fit adjusted.

    Attributes
    ----------
    description
        The effects.
    of_terms, of_noise
        Covariances of the terms' free parameters and of the logarithms of the noise's.
    limits
        Bounds of the logarithms of the noise's parameters in the fit.
    """

    description: Description
    of_terms: np.ndarray
    of_noise: np.ndarray
    limits: tuple[np.ndarray, np.ndarray]

    @classmethod
    def of(cls, fit: AxisFit) -> "FitUncertainty":
        """Return the uncertainty of a fit."""
        own = fit.without_cache()
        ends = limits(fit.description.noise, fit.sequence.bins, own.power)
        return cls(fit.description, own.covariance, fit.noise.covariance, ends)

    def draw(self, rng: np.random.Generator) -> dict[Effect, Effect]:
        """Draw the parameters; return the drawn effect for each adjusted one."""
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
    uncertainty
        Axis to the uncertainty of its fit; effects in no fit are taken as exact.
    """

    model: ErrorModel
    uncertainty: Mapping[str, FitUncertainty] = field(default_factory=dict)

    @classmethod
    def of(cls, model: ErrorModel, fits: Mapping[str, AxisFit]) -> "UncertainModel":
        """Return a model whose effects come from the fits of its axes."""
        return cls(model, {axis: FitUncertainty.of(found) for axis, found in fits.items()})

    def draw(self, rng: np.random.Generator) -> ErrorModel:
        """Draw a model: terms under their covariance, logarithms of the noise's parameters under its information."""
        axes = {}
        for axis, model in self.model.axes.items():
            drawn = self.uncertainty[axis].draw(rng) if axis in self.uncertainty else {}
            axes[axis] = AxisModel(tuple(drawn.get(effect, effect) for effect in model))
        return ErrorModel(axes)


def _normal(covariance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw normal values of mean zero; the covariance may be singular or empty."""
    values, vectors = np.linalg.eigh(covariance)
    return vectors @ (np.sqrt(np.maximum(values, 0.0)) * rng.standard_normal(len(values)))
