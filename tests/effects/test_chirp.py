"""A chirp: simulated, found, placed, named, and taken out where it is not needed."""

import numpy as np
import pytest

from imugap.discovery.device import Settings, discover
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Search
from imugap.effects import CATALOGUE, Bias, Chirp, Sinusoid, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.log import from_samples
from imugap.model import ErrorModel
from imugap.stream import stream

INTERVAL, COUNT = 0.02, 20_000
DURATION, STD = INTERVAL * COUNT, 1e-4 / np.sqrt(INTERVAL)
KNOWN = STD * np.sqrt(2 / COUNT)
"""Standard deviation with which the amplitude of a line can be known."""


def conditions(count=COUNT):
    return Conditions(INTERVAL * np.arange(count), INTERVAL, axis="gyro_y")


def sequence(values):
    return AxisSequence(values, conditions(len(values)))


def white(*labels):
    return STD * stream(11, "chirp", *labels).standard_normal(COUNT)


def found(seed, *hidden):
    """Discover the log of two axes of which the second one has what is hidden."""
    alone = AxisModel((WhiteNoise(1e-4), Bias(1e-4)))
    model = ErrorModel({"gyro_x": alone, "gyro_y": AxisModel((*alone, *hidden))})
    still = from_samples({axis: np.zeros(COUNT) for axis in model.axes}, INTERVAL)
    settings = Settings(replicates=20, simulations=10)
    return discover([model.simulate(still, seed, "plug-in")], settings)


def names(discovery):
    return [(one.name, one.axes) for one in discovery.findings]


def test_its_frequency_goes_up_by_the_chirp_rate():
    at, effect = conditions(4000), Chirp(1.5, 0.07, 0.3, 0.4)
    angle = np.unwrap(
        np.angle(
            Chirp(1.5, 0.07, 1.0, 0.4).sample(at, None) - 1j * Chirp(1.5, 0.07, 1.0, 0.4 + np.pi / 2).sample(at, None)
        )
    )
    middle = at.time[:-1] + INTERVAL / 2
    np.testing.assert_allclose(np.diff(angle) / (2 * np.pi * INTERVAL), 1.5 + 0.07 * middle, rtol=1e-9)
    assert np.abs(effect.sample(at, None)).max() == pytest.approx(0.3, rel=1e-4)


def test_without_a_rate_it_is_a_sinusoid():
    at = conditions(1000)
    np.testing.assert_array_equal(Chirp(3.0, 0.0, 0.2, 1.0).sample(at, None), Sinusoid(3.0, 0.2, 1.0).sample(at, None))


def test_its_slopes_are_its_derivatives():
    at, values = conditions(500), {"frequency": 1.5, "chirp_rate": -0.07, "amplitude": 0.3, "phase": 0.4}
    for name, slope in Chirp(**values).slopes(at).items():
        step = 1e-6
        up, down = (Chirp(**values | {name: values[name] + way * step}).sample(at, None) for way in (1, -1))
        np.testing.assert_allclose(slope, (up - down) / (2 * step), atol=1e-6 * np.abs(slope).max())


def test_its_rate_is_known_to_the_published_bound():
    """Djuric and Kay 1990: variance 90 s^2/(A^2 N (N^2-1) (N^2-4)) of half the rate in complex noise of variance s^2.

    A cosine in real noise carries the information of a complex line in noise of four times its variance.
    """
    effect = Chirp(3.0, 0.01, 20 * KNOWN)
    entry = Entry(effect, ("frequency", "chirp_rate", "amplitude", "phase"))
    description = Description.known(WhiteNoise(1e-4)).adding(entry)
    fitted = fit(sequence(white("bound") + effect.sample(conditions(), None)), description)
    bound = 90 * 4 * STD**2 / effect.amplitude**2 / (COUNT * (COUNT**2 - 1.0) * (COUNT**2 - 4.0))
    std = np.sqrt(bound) / (np.pi * INTERVAL**2)
    assert np.sqrt(fitted.covariance[1, 1]) == pytest.approx(std, rel=0.1)


@pytest.mark.parametrize(("begin", "end"), [(1.0, 4.0), (6.0, 2.5), (5.0, 5.03), (20.0, 21.0), (1.5, 20.0)])
def test_it_proposes_itself_where_it_is(begin, end):
    truth = Chirp(begin, (end - begin) / DURATION, 15 * KNOWN, 1.0)
    noise = fit(sequence(white(begin) + truth.sample(conditions(), None)), Description.known(WhiteNoise(1e-4)))
    (start,) = Chirp.starts(noise)
    assert abs(start.effect.frequency - begin) < 0.6 / DURATION
    assert abs(start.effect.chirp_rate - truth.chirp_rate) < 1 / DURATION**2
    assert start.effect.amplitude == pytest.approx(truth.amplitude, rel=0.3)
    assert start.gain > 60  # 15^2/2 = 112 of a start without error


def test_a_grid_in_parts_has_the_same_peak(monkeypatch):
    """A long log has a grid of gigabytes, of which a part is held at a time."""
    truth = Chirp(6.0, -3.5 / DURATION, 15 * KNOWN, 1.0)
    noise = fit(sequence(white(6.0) + truth.sample(conditions(), None)), Description.known(WhiteNoise(1e-4)))
    (whole,) = Chirp.starts(noise)
    monkeypatch.setattr("imugap.effects.chirp.GRID", 1)
    (parts,) = Chirp.starts(noise.without_cache())
    assert parts == whole


@pytest.mark.slow
def test_the_gain_of_noise_is_seldom_significant():
    """The highest gain of so many trials goes beyond log(trials/share) with the probability share, at most."""
    noise = [fit(sequence(white("chance", run)), Description.known(WhiteNoise(1e-4))) for run in range(30)]
    starts = [next(Chirp.starts(one)) for one in noise]
    assert sum(start.gain > np.log(start.trials / 0.1) for start in starts) <= 7  # 0.1 of 30 and 2.4 deviations


@pytest.mark.parametrize(
    ("seed", "begin", "end", "size"),
    [
        (1, 1.0, 4.0, 15),
        pytest.param(2, 6.0, 2.5, 40, marks=pytest.mark.slow),
        pytest.param(3, 5.0, 5.03, 30, marks=pytest.mark.slow),
    ],
)
def test_a_chirp_is_found_placed_and_named(seed, begin, end, size):
    truth = Chirp(begin, (end - begin) / DURATION, size * KNOWN, 1.0)
    discovery = found(seed, truth)
    assert names(discovery) == [("chirp", ("gyro_y",))]
    (one,) = discovery.findings
    for name, interval in one.parameters.items():
        half = (interval.high - interval.low) / 2
        assert abs(interval.value - getattr(truth, name)) < 1.8 * half  # 3.5 standard deviations
    assert one.parameters["chirp_rate"].high - one.parameters["chirp_rate"].low < 0.6 / DURATION**2 * 40 / size
    assert discovery.unexplained == ()
    assert discovery.distances["distribution"].after.value < discovery.distances["distribution"].before.value


@pytest.mark.parametrize(
    "hidden",
    [(), pytest.param((Sinusoid(5.0, 30 * KNOWN, 1.0),), marks=pytest.mark.slow)],
    ids=["nothing", "a steady line"],
)
def test_nothing_else_is_called_a_chirp(hidden):
    assert [name for name, _ in names(found(4, *hidden))] == [one.name for one in hidden]


def test_a_chirp_that_the_log_does_not_need_is_taken_out_again():
    """A search removes it from noise, and exchanges it for the sinusoid that it stands for."""
    line, noise = Sinusoid(5.0, 30 * KNOWN, 1.0), Description.known(WhiteNoise(1e-4))
    free = ("frequency", "chirp_rate", "amplitude", "phase")
    search = Search(noise, tuple(CATALOGUE.values()), np.log(0.01 / 6 / len(CATALOGUE)))
    for values, effect, left in (
        (white("none"), Chirp(5.0, 0.01, KNOWN), []),
        (white("line") + line.sample(conditions(), None), Chirp(5.0, 1e-7, 30 * KNOWN, 1.0), ["sinusoid"]),
    ):
        begun = fit(sequence(values), noise.adding(Entry(effect, free)))
        settled = search.refined(begun).description
        assert [term.effect.name for term in settled.terms] == left
