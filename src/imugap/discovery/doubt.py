"""Is a name right, or only the nearest one in the catalogue? Each effect is held against its own near misses.

A right description leaves nothing in the directions in which its effects could be slightly something else: a line
that drifts, a trend that bends, a spectrum of another slope, a stretch whose variance is not constant. Where chance
does not explain what is left there, the name is withheld and the place reported as unexplained.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.fft import idct, rfft
from scipy.stats import ncx2

from imugap.discovery import hysteresis, waves
from imugap.discovery.axis import AxisFit
from imugap.discovery.noise import STEP, Noise, log_likelihood
from imugap.discovery.parameters import term_intervals
from imugap.discovery.power_law import PowerLaw
from imugap.discovery.search import MANY, SLOW, Key, Search, Trial, at, log_chance, removed
from imugap.discovery.telegraph import compare
from imugap.discovery.unsteady import NEAR
from imugap.effects import RandomTelegraph, Sinusoid
from imugap.effects.effect import TINY, StochasticEffect
from imugap.stream import stream

LEVEL = np.log(3e-3)
"""Log-probability of chance below which a name is in doubt."""
OTHER_SLOPE = np.log(1e-2)
"""The same where slow noise with a free slope does better: one question, and no other test answers it as well."""
SHARE = 0.05
"""Share of the variance of a band above which an effect answers for the band."""
BANDS = 24
SLIGHT = 0.05
"""Relative deviation of the power in a band that leaves a name as it is: no real spectrum is one of a catalogue."""
BLOCKS = 12
"""Blocks of a stretch of another variance, and bands of its frequencies, that have to agree."""
INNER = 0.95
"""Share of the frequencies in use whose power no edge of a stretch makes less."""
DRAWN, PARTS, FEWEST, MOST = 1999, 20, 40, 6000
"""Draws of Gaussian noise, how many parts they are handled in; the fewest coefficients that tell its shape, the most
that are asked."""
USUAL = (-1.0, 1.0), (2.0, 6.0)
"""Skewness and kurtosis that leave a name as it is: no real noise is quite Gaussian; up to that of Laplace's law."""
HARMONICS, ALONE = 9, 0.1
"""Highest multiple of a line, and share of its frequency, or of the distance of lines, within which these are known."""
FAR = 2.0
"""Factor of the frequency of a line in doubt beyond which others have nothing to do with it."""


@dataclass(frozen=True)
class Doubt:
    """Why a name is withheld, and the log-probability that chance makes as much of it."""

    reason: str
    log_p: float


def doubts(search: Search, fit: AxisFit) -> dict[Key, Doubt]:
    """Return the added effects of a fit whose names are in doubt; with one in doubt, all of its part of the model.

    Beside lines in doubt a term keeps its name that is certain from other frequencies.
    """
    keys = search.added(fit.description)
    found = {key: doubt for key in keys if (doubt := _doubt(search, fit, key)) is not None}
    for kind, most in MANY.items():
        same = [key for key in keys if isinstance(at(fit.description, key), kind)]
        if len(same) > most:
            found |= {key: Doubt(f"{len(same)} of them", -np.inf) for key in same}
    found |= _after_clusters(search, fit, found) | _beside_a_mean(search, fit, keys, found)
    clear = _clear_of_lines(search, fit, keys, found)
    for part in {key.part for key in found}:
        worst = min((found[key] for key in found if key.part == part), key=lambda doubt: doubt.log_p)
        found |= {key: worst for key in keys if key.part == part and key not in found and key not in clear}
    return found


def _clear_of_lines(search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Doubt]) -> set[Key]:
    """Return the terms that, lines alone being in doubt, are certain from frequencies far from these."""
    doubtful = [at(fit.description, key) for key in found if key.part == "term"]
    if not doubtful or not all(isinstance(effect, Sinusoid) for effect in doubtful):
        return set()
    lines = [line.frequency for line in doubtful]
    others = [key for key in keys if key.part == "term" and key not in found]
    return {key for key in others if _certain_outside(search, fit, key, min(lines) / FAR, max(lines) * FAR)}


def _certain_outside(search: Search, fit: AxisFit, key: Key, low: float, high: float) -> bool:
    """Return whether chance does not explain what an effect gains outside of a band of frequencies [Hz]."""
    own, without = search.weighed(fit, key)
    frequency = np.arange(1, fit.sequence.bins.last + 1) / (2 * len(fit.residual) * fit.sequence.conditions.interval)
    outside = (frequency < low) | (frequency > high)
    full, less = (
        np.sum((one.coefficients[: len(frequency)] ** 2 + np.log(one.variance[: len(frequency)]))[outside])
        for one in (fit, without)
    )
    return replace(own, gain=0.5 * float(less - full)).log_p < search.log_alpha


def _after_clusters(search: Search, fit: AxisFit, found: Mapping[Key, Doubt]) -> dict[Key, Doubt]:
    """Return the random effects that only the samples without outliers show, where those are in doubt."""
    doubt = next((found[key] for key in found if key.part == "outliers"), None)
    if doubt is None:
        return {}
    raw = search.fitted(search.raw[fit.description.outliers], replace(fit.description, outliers=None))
    random = [key for key in search.added(raw.description) if key.part != "term"]
    return {key: doubt for key in random if search.weighed(raw, key)[0].log_p > search.log_alpha}


def _beside_a_mean(search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Doubt]) -> dict[Key, Doubt]:
    """Return the slow random effects that may stand for what a mean of no known shape leaves.

    A line leaves nothing below itself: an effect that is certain from the frequencies there keeps its name.
    """
    bent = {key: found[key].log_p for key in found if key.part == "term"}
    if not bent:
        return {}
    lowest = min(getattr(at(fit.description, key), "frequency", 0.0) for key in bent)
    slow = [key for key in keys if key.part == "noise" and isinstance(at(fit.description, key), SLOW)]
    doubtful = [key for key in slow if _evidence_below(fit, key, 0.5 * lowest) < -search.log_alpha]
    return {key: Doubt("the mean beside it has no known shape", min(bent.values())) for key in doubtful}


def _evidence_below(fit: AxisFit, key: Key, frequency: float) -> float:
    """Return the gain of log-likelihood that a random effect makes below a frequency [Hz], all else as it is."""
    bins = fit.sequence.bins
    below = bins.frequency < frequency
    power = (bins.sums(fit.coefficients**2) * fit.description.noise.variance(bins))[below]
    parts = [noise.variance(bins)[below] for noise in (fit.description.noise, removed(fit.description, key).noise)]
    full, without = (log_likelihood(part, power, bins.number[below]) for part in parts)
    return full - without


def _doubt(search: Search, fit: AxisFit, key: Key) -> Doubt | None:
    tests = {"term": _bends, "noise": _another_spectrum, "change": _uneven, "outliers": _clustered, "filter": _nothing}
    doubt = tests[key.part](search, fit, key)
    return doubt if doubt is not None and doubt.log_p < LEVEL else None


def _nothing(search: Search, fit: AxisFit, key: Key) -> None:
    """Have no doubt: the catalogue's filters stand for all low-pass filters."""


def _bends(search: Search, fit: AxisFit, key: Key) -> Doubt | None:
    unresolved = _unresolved(fit, key)
    if unresolved is not None:
        return unresolved
    if _harmonic(fit, key):
        return Doubt("lines at its multiples make it a wave of another shape", -np.inf)
    if _split(fit, key) or _modulated(fit, key):
        return Doubt("lines beside it make it one that swells or drifts", -np.inf)
    return Doubt("the mean is not quite of its shape", nearly(fit, key.index))


def nearly(fit: AxisFit, index: int) -> float:
    """Return the log-probability that a term is as far from its shape, in the likeliest of the ways that it may be."""
    ways = fit.description.terms[index].effect.near_misses(fit.sequence.conditions)
    found = [log_chance(gain, rank) for gain, rank in (fit.joint_gain(fit.whiten(way)) for way in ways) if rank]
    return min(found, default=0.0) + np.log(max(len(found), 1))


def _harmonic(fit: AxisFit, key: Key) -> bool:
    """Return whether a line and another one are multiples of each other, of a frequency that is known well enough."""
    lines = _lines(fit)
    if key.index not in lines:
        return False
    for index, other in lines.items():
        (slow, slow_width), (fast, fast_width) = sorted([lines[key.index], other])
        ratio = np.rint(fast / slow)
        tolerance = fast_width + ratio * slow_width
        if index != key.index and 2 <= ratio <= HARMONICS and abs(fast - ratio * slow) < tolerance < ALONE * slow:
            return True
    return False


def _lines(fit: AxisFit) -> dict[int, tuple[float, float]]:
    """Return frequency [Hz] and width of its interval of each line, by the index of its term."""
    return {
        index: (term.effect.frequency, np.diff(term_intervals(fit, index)["frequency"])[0])
        for index, term in enumerate(fit.description.terms)
        if isinstance(term.effect, Sinusoid)
    }


def _split(fit: AxisFit, key: Key) -> bool:
    """Return whether another line is so near to one that both may be parts of a line that is not steady."""
    lines = _lines(fit)
    duration = fit.sequence.conditions.interval * len(fit.residual)
    return key.index in lines and any(
        abs(line - lines[key.index][0]) < NEAR / duration for index, (line, _) in lines.items() if index != key.index
    )


def _modulated(fit: AxisFit, key: Key) -> bool:
    """Return whether a line is one of three of equal distance, which is known well enough: carrier and sidebands."""
    lines = sorted((*line, index) for index, line in _lines(fit).items())
    for (low, left, first), (middle, own, second), (high, right, third) in combinations(lines, 3):
        tolerance = left + 2 * own + right
        even = abs(low + high - 2 * middle) < tolerance < ALONE * (high - low) / 2
        if even and key.index in (first, second, third):
            return True
    return False


def _unresolved(fit: AxisFit, key: Key) -> Doubt | None:
    """Doubt an effect of which the log does not tell a parameter from nothing: a transient of a sample or two."""
    limits = at(fit.description, key).limits()
    ends = term_intervals(fit, key.index)
    lost = [name for name, (low, _) in ends.items() if limits[name][0] == TINY and low <= TINY]
    return Doubt(f"the log does not tell its {lost[0]}", -np.inf) if lost else None


def _clustered(search: Search, fit: AxisFit, key: Key) -> Doubt:
    return Doubt("they come in clusters", search.tails[fit.description.outliers].clustered)


def _uneven(search: Search, fit: AxisFit, key: Key) -> Doubt:
    """Compare the energies of blocks within the stretch, and those of bands of the frequency."""
    inside = fit.whitened[fit.description.changes[key.index].within(fit.sequence.conditions.time)]
    used = fit.sequence.bins.last / len(fit.coefficients)
    power = np.abs(rfft(inside - inside.mean()))[1 : int(INNER * used * len(inside) / 2)] ** 2
    return min(
        Doubt("the variance changes within the stretch", _scatter(inside**2, 1)),
        Doubt("the variance of some frequencies changes more than that of others", _scatter(power, 2)),
        key=lambda doubt: doubt.log_p,
    )


def _scatter(energies: np.ndarray, each: int) -> float:
    """Return the log-probability that the means of blocks of chi-square energies scatter so."""
    blocks = np.array_split(energies, min(BLOCKS, max(each * len(energies) // 8, 1)))
    number = each * np.array([len(block) for block in blocks])
    gain = _divergence(np.array([block.mean() for block in blocks]) / energies.mean() * number, number).sum()
    return log_chance(float(gain), len(blocks) - 1) if len(blocks) > 1 else 0.0


def _another_spectrum(search: Search, fit: AxisFit, key: Key) -> Doubt | None:
    """Test slope and shape of the spectrum where the process answers for it, and against one power law for all."""
    effect = at(fit.description, key)
    bins = fit.sequence.bins
    share = share_of(fit, effect)
    slope = _score(fit, share * np.log(bins.frequency / bins.frequency[0]))
    doubts = [Doubt("its spectrum has another slope", slope), _off_in_bands(fit, share)]
    if isinstance(effect, RandomTelegraph):
        verdict = compare(fit, (effect,))
        uneven = log_chance(verdict.uneven, 1)
        doubts.append(Doubt("it is at one of its values more often than at the other", uneven))
        if sum(key.part == "noise" for key in search.added(fit.description)) == 1:
            doubts.append(Doubt("its samples and its spectrum disagree", _at_odds(fit, key, verdict.effect)))
    else:
        doubts.append(Doubt("it comes in bursts or jumps", _uncommon(fit, share)))
    if isinstance(effect, (*SLOW, RandomTelegraph)):
        doubts += [_repeated(search, fit, key), _remembered(search, fit, key)]
    law = _power_law(search, fit)
    return min([*doubts, *([law] if law is not None else [])], key=lambda doubt: doubt.log_p)


def _repeated(search: Search, fit: AxisFit, key: Key) -> Doubt:
    """Weigh a wave of any shape in the place of slow noise."""
    own, without = search.weighed(fit, key)
    wave = log_chance(waves.gain(without), waves.MORE) + np.log(waves.TRIALS)
    return Doubt("a wave of one period explains it better", _over(own, wave, search.log_alpha))


def _remembered(search: Search, fit: AxisFit, key: Key) -> Doubt:
    """Weigh a loop over the temperature in the place of slow noise."""
    own, without = search.weighed(fit, key)
    loop = log_chance(hysteresis.gain(without), hysteresis.MORE) + np.log(len(hysteresis.HALVES))
    return Doubt("a memory of the temperature explains it better", _over(own, loop, search.log_alpha))


def _over(own: Trial, other: float, log_alpha: float) -> float:
    """Return the log-probability of a doubt that is at the level where another mean does as well as the noise."""
    return LEVEL + other - own.log_p if other < log_alpha else 0.0


def _uncommon(fit: AxisFit, share: np.ndarray) -> float:
    """Return the log-probability that Gaussian noise is as skewed, or of as high or low a kurtosis.

    Asked of the whitened log, each frequency weighed by the share that the effect has in it: an impulse in what drives
    a process stays one there. Gaussian noise so weighed is drawn :data:`DRAWN` times.
    """
    bins = fit.sequence.bins
    weight = bins.spread(np.maximum(share, TINY))[: min(bins.last, MOST)]
    last = max(np.flatnonzero(weight > SHARE), default=0) + 1
    if last < FEWEST:
        return 0.0
    own = _shape(weight[:last] * fit.coefficients[None, :last])[0]
    if all(low < value < high for value, (low, high) in zip(own, USUAL, strict=True)):
        return 0.0
    noise = weight[:last] * stream(0, "uncommon", last).standard_normal((DRAWN, last))
    drawn = np.concatenate([_shape(part) for part in np.array_split(noise, PARTS)])
    rank = np.sum(drawn >= own, axis=0) + 1
    two_sided = 2 * np.minimum(rank, DRAWN + 2 - rank) / (DRAWN + 1)
    return float(np.log(min(len(own) * two_sided.min(), 1.0)))


def _shape(coefficients: np.ndarray) -> np.ndarray:
    """Return skewness and kurtosis of signals, shape (signals, 2), from their cosine coefficients in rows."""
    values = idct(np.pad(coefficients, ((0, 0), (1, coefficients.shape[1] - 1))), norm="ortho")
    scaled = values / values.std(axis=1, keepdims=True)
    return np.column_stack([np.mean(scaled**3, axis=1), np.mean(scaled**4, axis=1)])


def _at_odds(fit: AxisFit, key: Key, other: StochasticEffect) -> float:
    """Return the log-probability that the spectrum is as unlikely as it is with another effect at ``key``."""
    bins, noise = fit.sequence.bins, fit.description.noise
    effects = tuple(other if i == key.index else one for i, one in enumerate(noise.effects))
    variances = noise.variance(bins), replace(noise, effects=effects).variance(bins)
    power = bins.sums(fit.coefficients**2) * variances[0]
    best, here = (log_likelihood(variance, power, bins.number) for variance in variances)
    return log_chance(best - here, len(other.parameters()))


def share_of(fit: AxisFit, effect: StochasticEffect) -> np.ndarray:
    """Return the share of an effect in the variance of each bin."""
    bins, noise = fit.sequence.bins, fit.description.noise
    own = Noise((effect,), noise.output_filter).variance(bins)
    return own / noise.variance(bins)


def _score(fit: AxisFit, direction: np.ndarray) -> float:
    """Return the log-probability of the score of the log-spectrum in a direction, the parameters free to follow."""
    bins, noise = fit.sequence.bins, fit.description.noise
    theta, variance = noise.theta(), noise.variance(bins)
    slopes = [(noise.at(theta + step).variance(bins) / variance - 1) / STEP for step in STEP * np.eye(len(theta))]
    weighted = np.sqrt(bins.number / 2)
    basis = np.linalg.qr((np.array(slopes) * weighted).T)[0]
    rest = direction * weighted - basis @ (basis.T @ (direction * weighted))
    excess = (bins.sums(fit.coefficients**2) / bins.number - 1) * weighted
    norm = rest @ rest
    return log_chance(0.5 * float(rest @ excess) ** 2 / norm, 1) if norm > 1e-6 else 0.0


def _off_in_bands(fit: AxisFit, share: np.ndarray) -> Doubt:
    """Compare the power of bands that the effect answers for with the fit, slight deviations allowed for."""
    bins = fit.sequence.bins
    mine = np.flatnonzero(share > SHARE)
    if len(mine) < 2:
        return Doubt("its spectrum has another shape", 0.0)
    edges = np.unique(np.geomspace(bins.frequency[mine[0]], bins.frequency[mine[-1]] * 1.001, BANDS + 1))
    band = np.digitize(bins.frequency[mine], edges)
    number = np.bincount(band, bins.number[mine])
    power = np.bincount(band, bins.sums(fit.coefficients**2)[mine])
    used = number >= 8
    deviation = (power[used] / number[used] - 1) * np.sqrt(number[used] / 2)
    normal = np.sign(deviation) * np.sqrt(2 * _divergence(power[used], number[used]))
    free = max(int(used.sum()) - len(fit.description.noise.parameters()), 1)
    slight = 0.5 * SLIGHT**2 * float(number[used].sum())
    chance = float(ncx2.sf(np.sum(normal**2), free, slight))
    return Doubt("its spectrum has another shape", float(np.log(max(chance, TINY))))


def _divergence(power: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Return the gain of log-likelihood of a free variance in each band."""
    ratio = power / number
    return 0.5 * number * (ratio - 1 - np.log(ratio))


def _power_law(search: Search, fit: AxisFit) -> Doubt | None:
    """Weigh one power law against the added slow processes: its slope may be another, or it says more than two do."""
    first = len(search.start.noise.effects)
    noise = fit.description.noise
    slow = [effect for effect in noise.effects[first:] if isinstance(effect, SLOW)]
    if not slow:
        return None
    kept = tuple(effect for effect in noise.effects if not any(effect is one for one in slow))
    without = search.fitted(fit.sequence, replace(fit.description, noise=replace(noise, effects=kept)))
    size = max(without.room(PowerLaw(1.0, 1.5)), 1e-12 * float(np.sqrt(without.variance.mean())))
    law = replace(without.description, noise=replace(noise, effects=(*kept, PowerLaw(size, 1.5))))
    other = search.fitted(fit.sequence, law)
    if len(slow) == 1:
        chance = log_chance(other.log_likelihood - fit.log_likelihood, 1)
        return Doubt("a power law of another slope explains it better", LEVEL - OTHER_SLOPE + chance)
    named = log_chance(fit.log_likelihood - without.log_likelihood, sum(len(one.parameters()) for one in slow))
    unnamed = log_chance(other.log_likelihood - without.log_likelihood, 2)
    return Doubt("one power law explains all slow noise better", LEVEL + unnamed - named)
