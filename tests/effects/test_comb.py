"""A comb: simulated, joined from lines and chirps, named with its parameters, and not seen where there is none."""

import numpy as np
import pytest
from tests.effects.test_chirp import DURATION, KNOWN, conditions, found, names, sequence, white

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.search.search import Search
from imugap.discovery.search.simpler_form import simplified
from imugap.effects import CATALOGUE, Chirp, Comb, Sinusoid, WhiteNoise
from imugap.stream import stream

KNOWN_NOISE = Description.known(WhiteNoise(1e-4))
SEARCH = Search(KNOWN_NOISE, tuple(CATALOGUE.values()), np.log(0.01 / 6 / len(CATALOGUE)))
CHIRP = ("frequency", "chirp_rate", "amplitude", "phase")


def comb(seed, numbers, size, frequency, rate=0.0):
    """A comb of some harmonics with random sizes and phases."""
    rng = stream(seed, "comb")
    sizes = {f"amplitude_{k}": size * KNOWN * rng.uniform(0.6, 1.4) for k in numbers}
    return Comb(frequency, rate, **sizes, **{f"phase_{k}": rng.uniform(-3, 3) for k in numbers})


def tones(effect):
    """The chirps of which a comb is the sum."""
    return [
        Chirp(k * effect.frequency, k * effect.chirp_rate, a, effect.phase(k)) for k, a in effect.amplitudes.items()
    ]


def test_it_is_the_sum_of_its_harmonics():
    at, effect = conditions(500), Comb(2.0, 0.3, 0.5, 1.0, amplitude_3=0.2, phase_3=-0.4)
    expected = sum(tone.sample(at, None) for tone in tones(effect))
    np.testing.assert_allclose(effect.sample(at, None), expected, atol=1e-12)
    assert not Comb(2.0).sample(at, None).any()


def test_its_steady_form_has_the_phases_of_the_middle():
    effect, middle = comb(1, (1, 2, 5), 30, 3.0, 1e-9), DURATION / 2
    steady = effect.simpler(middle)
    assert "chirp_rate" not in steady.free
    np.testing.assert_allclose(steady.effect.sample(conditions(), None), effect.sample(conditions(), None), atol=1e-6)


@pytest.mark.parametrize("numbers", [(1, 2), (2, 3), (1, 4), (3, 5), (6, 1)])
def test_two_chirps_of_one_fundamental_join(numbers):
    truth, at = comb(2, numbers, 30, 1.7, 0.01), conditions()
    (start,) = Comb.joining(*tones(truth), at)
    np.testing.assert_allclose(start.effect.sample(at, None), truth.sample(at, None), atol=1e-6 * 30 * KNOWN)
    assert "chirp_rate" in start.free


def test_steady_lines_do_not_join():
    """They make a wave of any shape and cause."""
    assert not list(Comb.joining(Sinusoid(2.0, 1.0), Sinusoid(4.0, 1.0), conditions()))


def test_a_comb_takes_in_a_line_below_its_fundamental():
    upper, line = Comb(4.0, 0.02, 0.3, 0.1, 0.2, 0.2), Chirp(2.0, 0.01, 0.4, 0.5)
    (start,) = Comb.joining(upper, line, conditions())
    assert start.effect.amplitudes == {1: 0.4, 2: 0.3, 4: 0.2}


@pytest.mark.parametrize("other", [Sinusoid(8.1, 1.0), Sinusoid(5.0, 1.0), Comb(1.0, amplitude_5=1.0)])
def test_tones_of_no_ratio_or_of_the_same_harmonic_do_not_join(other):
    assert not list(Comb.joining(Sinusoid(5.0, 1.0), other, conditions()))


@pytest.mark.parametrize(("apart", "left"), [(0.0, ["comb"]), (0.5, ["chirp", "chirp"])])
def test_lines_join_where_their_ratio_is_whole_and_only_there(apart, left):
    """The second line is that many widths of a line off twice the first."""
    lines = [Chirp(3.0, 0.01, 30 * KNOWN, 1.0), Chirp(6.0 + apart / DURATION, 0.02, 20 * KNOWN, 2.0)]
    values = white("ratio") + sum(line.sample(conditions(), None) for line in lines)
    begun = fit(sequence(values), KNOWN_NOISE.adding(*(Entry(line, CHIRP) for line in lines)))
    assert [term.effect.name for term in SEARCH.joined(begun).description.terms] == left


def test_a_rate_that_may_be_zero_is_taken_out():
    truth = comb(3, (1, 2), 30, 3.0)
    begun = Comb(**truth.parameters() | {"chirp_rate": 1e-9}).start()
    entry = Entry(begun.effect, begun.free)
    found_terms = fit(sequence(white("constant") + truth.sample(conditions(), None)), KNOWN_NOISE.adding(entry))
    (term,) = simplified(SEARCH, found_terms).description.terms
    assert term.effect.chirp_rate == 0
    assert "chirp_rate" not in term.free


@pytest.mark.parametrize(
    ("seed", "numbers", "drift"),
    [
        pytest.param(2, (1, 2, 3, 4), 1.0, marks=pytest.mark.slow),
        pytest.param(3, (2, 3, 5), 1.0, marks=pytest.mark.slow),
        pytest.param(4, (1, 2, 3), 0.8, marks=pytest.mark.slow),
        (5, (1, 2), -1.0),
        pytest.param(6, (1, 2, 3, 4, 5, 6), 1.5, marks=pytest.mark.slow),
    ],
)
def test_a_comb_is_named_with_its_parameters(seed, numbers, drift):
    truth = comb(seed, numbers, 30, 2.4 + 0.1 * seed, drift / DURATION)
    discovery = found(seed, truth)
    assert names(discovery) == [("comb", ("gyro_y",))]
    (one,) = discovery.findings
    for name, interval in one.parameters.items():
        half = (interval.high - interval.low) / 2
        off = interval.value - getattr(truth, name)
        off = np.angle(np.exp(1j * off)) if name.startswith("phase") else off
        assert abs(off) <= 1.8 * half, name  # 3.5 standard deviations
    assert discovery.unexplained == ()


def test_a_steady_comb_has_a_place_and_no_name():
    """A wave of any shape and cause has such lines."""
    discovery = found(1, comb(1, (1, 2, 3), 30, 2.5))
    assert names(discovery) == []
    assert {one.name for one in discovery.withheld} == {"sinusoid"}
    assert discovery.unexplained


@pytest.mark.slow
@pytest.mark.parametrize(
    "hidden",
    [(), (Sinusoid(5.0, 30 * KNOWN, 1.0),), (Sinusoid(5.0, 30 * KNOWN, 1.0), Sinusoid(8.137, 20 * KNOWN, 2.0))],
)
def test_nothing_else_is_called_a_comb(hidden):
    assert [name for name, _ in names(found(4, *hidden))] == [one.name for one in hidden]
