"""Description of noise that has no name: its spectrum, and the distribution of its single samples.

A description explains nothing. It is in a model of its own (:class:`NamelessNoise`), which simulates logs that are like
the measured one. A spectrum is described by bands of flat noise. They are found by segmentation of the periodogram
relative to the spectrum of the final model; where that spectrum is above the periodogram, the density of the white
noise is reduced. A distribution is described by its quantiles.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imugap.discovery.axis import AxisResult, part
from imugap.discovery.evaluation.distance import Distances, Evaluation, HeldOutComparison
from imugap.discovery.evaluation.held_out import HELD_IN_SHARE, of_one_run
from imugap.discovery.finding import Discrepancy
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.preparation.cosine_bins import Bins
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects import BandNoise, NoiseDistribution
from imugap.effects.effect import AxisModel, Effect
from imugap.model import ErrorModel, white_noise
from imugap.numerics.spectra.periodogram_segments import segments

SPECTRAL, MARGINAL = ("allan", "spectrum", "line"), ("marginal", "extremes")
"""Views that a spectrum without a name shows in, and those of a distribution."""
CHANCE = 3.0
"""Gain of log-likelihood of a band over the final model, less log(n + 1) for n coefficients, that may be chance."""
MOST_BANDS = 30
"""Largest number of bands of an axis."""
MIN_GAIN = 0.05
"""Power gain of an output filter below which nothing is said of the noise ahead of it."""
MIN_WHITE_SHARE = 0.5
"""Share of white noise in the variance of a sample from which on it has the distribution of the samples."""


@dataclass(frozen=True, eq=False)
class NamelessNoise:
    """Model of a device with a description of what has no name.

    Attributes
    ----------
    model
        The final model with the descriptions.
    effects
        Descriptions of each axis that has one.
    distances
        Distances in distribution on held-out data: before is that of the final model, after that with the descriptions.
    """

    model: ErrorModel
    effects: Mapping[str, tuple[Effect, ...]]
    distances: Distances

    def sentence(self) -> str:
        """Return what is described, and what that changes, as text."""
        axes = "; ".join(f"{axis}, {_in_words(some)}" for axis, some in self.effects.items())
        apart = self.distances
        return (
            f"Described without a name, for simulations (described.yaml): {axes}. Distance in distribution with it "
            f"{apart.after.value:.3g}; floor {apart.floor.low:.3g} to {apart.floor.high:.3g}."
        )


def describe(
    places: Sequence[Discrepancy],
    results: Mapping[str, AxisResult],
    sequences: Mapping[str, AxisSequence],
    model: Callable[[Mapping[str, AxisFit]], ErrorModel],
    compared: Sequence[HeldOutComparison],
    tested: bool,
    evaluate: Callable[[Sequence[HeldOutComparison]], Evaluation],
) -> NamelessNoise | None:
    """Describe the noise without a name of each axis where that brings simulations nearer to held-out data.

    The held-out data choose the axes, but no value: each description is fitted to the part before them.

    Parameters
    ----------
    places
        Remaining discrepancies.
    results, sequences
        Result of each axis, and the samples before anything was removed from them.
    model
        Model of the device for fits of its axes.
    compared, tested
        Held-out data, and whether they are further runs; else they are the last part of the log, and the description
        that is compared with them is that of the part before it.
    evaluate
        Function that gives the distances.
    """
    views = {axis: {place.view for place in places if axis in place.axis.split(",")} for axis in results}
    whole = {axis: _on(one.whole_fit, one, sequences[axis], 1.0) for axis, one in results.items()}
    seen = whole
    if not tested:
        seen = {axis: _on(one.training_fit, one, sequences[axis], HELD_IN_SHARE) for axis, one in results.items()}
    axes = {axis for axis, shown in views.items() if shown & {*SPECTRAL, *MARGINAL}}
    while axes:
        early = _described(model(seen), seen, views, axes)[0]
        named = [replace(one, before=one.after, after=of_one_run(early)) for one in compared]
        evaluation = evaluate(named)
        nearer = {axis for axis in axes if _nearer(evaluation.axes[axis])}
        if nearer == axes:
            final, effects = _described(model(whole), whole, views, axes)
            return NamelessNoise(final, effects, evaluation.distances["distribution"])
        axes = nearer
    return None


def _nearer(apart: Distances) -> bool:
    """Return whether the model with descriptions is nearer to held-out data than the final model."""
    return apart.after.value < apart.before.value


def _on(fit: AxisFit, result: AxisResult, sequence: AxisSequence, share: float) -> AxisFit:
    """Return a fit on the samples that still have the unsteady lines that were removed before it."""
    return replace(fit, sequence=part(sequence, 0, int(share * len(sequence.values)))) if result.bands else fit


def _described(
    model: ErrorModel, fits: Mapping[str, AxisFit], views: Mapping[str, set[str]], axes: set[str]
) -> tuple[ErrorModel, dict[str, tuple[Effect, ...]]]:
    """Return the model with descriptions of some axes, and the descriptions."""
    models, effects = dict(model.axes), {}
    for axis in (axis for axis in fits if axis in axes):
        models[axis], effects[axis] = _of_axis(models[axis], fits[axis], views[axis])
    return ErrorModel(models), {axis: some for axis, some in effects.items() if some}


def _of_axis(model: AxisModel, fit: AxisFit, views: set[str]) -> tuple[AxisModel, tuple[Effect, ...]]:
    """Return the model of an axis with descriptions, and these."""
    bands, taken = _bands(fit) if views & set(SPECTRAL) else ((), 0.0)
    white = float(np.sqrt(max(sum(one.density**2 for one in model if one.white) - taken, 0.0)))
    std = white / np.sqrt(fit.sequence.conditions.interval)
    shaped = bool(views & set(MARGINAL)) and std**2 > MIN_WHITE_SHARE * float(np.var(fit.residual))
    shape = (NoiseDistribution.of(fit.unrounded[~fit.sequence.flawed], std),) if shaped else ()
    kept = [_of_density(one, white, shaped) if one.white else one for one in model]
    return AxisModel((*kept, *bands, *shape)), (*bands, *shape)


def _of_density(noise: Effect, density: float, normal: bool) -> Effect:
    """Return white noise of another density, normal where a description of the distribution makes the law of it."""
    return white_noise(density) if normal else replace(noise, density=density)


def _bands(fit: AxisFit) -> tuple[tuple[BandNoise, ...], float]:
    """Return bands of noise for what the fit's spectrum lacks, and the PSD [unit^2/Hz] that its white noise loses."""
    bins, interval = fit.sequence.bins, fit.sequence.conditions.interval
    last = bins.last
    relative = fit.coefficients[:last] ** 2
    expected = fit.variance[:last] * interval
    gain = fit.description.noise.gain(fit.sequence.bins)[:last]
    found = [(first, stop) for first, stop in segments(relative, MOST_BANDS) if gain[first:stop].mean() > MIN_GAIN]
    excess = np.array([_excess(relative[a:b], expected[a:b], gain[a:b]) for a, b in found])
    white = sum(one.density**2 for one in fit.description.noise.effects if one.white)
    taken = float(min(max(-excess.min(initial=0.0), 0.0), white))
    psds = [(ends, more + taken) for ends, more in zip(found, excess, strict=True) if more + taken > 0]
    return tuple(_band(*ends, psd, bins) for ends, psd in psds), taken


def _band(first: int, stop: int, psd: float, bins: Bins) -> BandNoise:
    """Return noise of a PSD [unit^2/Hz] over some cosine coefficients; the outermost ones reach to the ends."""
    step = 1 / (2 * bins.count * bins.interval)
    low = (first + 0.5) * step if first else 0.0
    high = (stop + 0.5) * step if stop < bins.last else 0.5 / bins.interval
    return BandNoise(float(np.sqrt(psd)), float(low + high) / 2, float(high - low))


def _excess(relative: np.ndarray, expected: np.ndarray, gain: np.ndarray) -> float:
    """Return the mean PSD ahead of the filter that a band has beyond what is expected; 0 where that is chance."""
    mean = max(float(relative.mean()), np.finfo(float).tiny)
    if len(relative) / 2 * (mean - 1 - np.log(mean)) < np.log(len(relative) + 1) + CHANCE:
        return 0.0
    return float(np.mean((relative - 1) * expected / gain))


def _in_words(effects: Sequence[Effect]) -> str:
    """Return the descriptions of an axis as text."""
    bands = [one for one in effects if isinstance(one, BandNoise)]
    parts = [f"spectrum by {len(bands)} band{'s' if len(bands) > 1 else ''} of noise"] if bands else []
    return " and ".join([*parts, *(["distribution by quantiles"] if len(bands) < len(effects) else [])])
