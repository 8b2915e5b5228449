"""A dead zone: simulated, found, placed, named, and told from other flaws."""

import numpy as np
import pytest

from imugap.discovery.device import Settings, discover
from imugap.discovery.preparation.prepare import prepare
from imugap.effects import Bias, DeadZone, OutputFilter, Resolution, Saturation, StuckSamples, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.log import from_samples
from imugap.model import ErrorModel
from imugap.stream import stream

INTERVAL, COUNT = 0.01, 10_000
AT = Conditions(INTERVAL * np.arange(COUNT), INTERVAL, axis="gyro_y")


def noise(rng):
    return rng.standard_normal(COUNT)


def biased(rng):
    return 1.5 + rng.standard_normal(COUNT)


def wandering(rng):
    return 0.05 * np.cumsum(rng.standard_normal(COUNT)) + 0.1 * rng.standard_normal(COUNT)


def moving(rng):
    return 30 * np.sin(4.4 * AT.time + rng.uniform(0, 6)) + 0.3 * rng.standard_normal(COUNT)


def tailed(rng):
    return rng.standard_t(2, COUNT)


def far(rng):
    return 10 * np.sign(np.sin(0.1 * AT.time)) + rng.standard_normal(COUNT)


INPUTS = (noise, biased, wandering, moving, tailed, far)


def zeroed(values, rng):
    return np.where(rng.random(COUNT) < 0.01, 0.0, values)


def held_at_zero(values, rng):
    return np.where((AT.time > 20.0) & (AT.time < 23.0), 0.0, values)


def rounded(values, rng):
    return Resolution(0.1).apply(values, AT, rng)


def coarsely_rounded(values, rng):
    return Resolution(2.0).apply(values, AT, rng)


def stuck(values, rng):
    return StuckSamples(0.01, 5.0).apply(rounded(values, rng), AT, rng)


def clipped(values, rng):
    return Saturation(1.0).apply(values, AT, rng)


def smoothed(values, rng):
    return zeroed(OutputFilter(2.0).apply(values, AT, rng), rng)


OTHERS = (zeroed, held_at_zero, rounded, coarsely_rounded, stuck, clipped, smoothed)


def recorded(seed, *effects):
    """The log of two axes at rest of which the second one has the effects."""
    alone = AxisModel((WhiteNoise(1e-4), Bias(2e-4)))
    model = ErrorModel({"gyro_x": alone, "gyro_y": AxisModel((*alone, *effects))})
    return model.simulate(from_samples({axis: np.zeros(COUNT) for axis in model.axes}, INTERVAL), seed, "plug-in")


def test_the_output_is_zero_within_the_zone_and_the_input_outside():
    values = np.array([-1.1, -1.0, -0.9, 0.0, 0.5, 1.0, 3.0])
    np.testing.assert_array_equal(DeadZone(2.0).apply(values, AT, None), [-1.1, -1.0, 0, 0, 0, 1.0, 3.0])
    shares = DeadZone(2.0).apply(stream(1, "share").standard_normal(100_000), AT, None) == 0
    assert shares.mean() == pytest.approx(0.6827, abs=0.006)


def test_no_other_flaw_is_taken_for_it():
    """252 logs without a dead zone, of which one in a million may be named falsely."""
    for run in range(6):
        for make in INPUTS:
            for change in OTHERS:
                rng = stream(7, "without", make.__name__, change.__name__, run)
                assert DeadZone.found(change(make(rng), rng), AT) is None, (make, change, run)


@pytest.mark.parametrize("lattice", [0.0, 0.02])
def test_it_is_found_and_its_interval_holds_its_width(lattice):
    """Where the input is dense at the edges; the interval is of 95 %, on a lattice of one step and more."""
    runs, inside = 0, 0
    for make, width in ((noise, 0.3), (noise, 2.0), (biased, 1.0), (tailed, 0.3), (moving, 3.0)):
        for run in range(20):
            rng = stream(9, "with", make.__name__, width, run)
            values = DeadZone(width).apply(make(rng), AT, rng)
            evidence = DeadZone.found(Resolution(lattice).apply(values, AT, rng) if lattice else values, AT)
            low, high = evidence.intervals["width"]
            runs, inside = runs + 1, inside + (low <= width <= high)
            np.testing.assert_array_equal(evidence.flawed, values == 0)
    assert inside >= 88  # of 100, 95 and three standard deviations less
    assert lattice or inside < 100


def test_an_input_far_from_zero_says_nothing_of_it():
    rng = stream(3, "far")
    assert DeadZone.found(DeadZone(0.3).apply(far(rng), AT, rng), AT) is None


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("width", [1e-3, pytest.param(2e-3, marks=pytest.mark.slow)])
def test_a_dead_zone_is_found_placed_and_named(seed, width):
    settings = Settings(replicates=20, simulations=10)
    discovery = discover([recorded(seed, DeadZone(width))], settings)
    (one,) = discovery.findings
    assert (one.name, one.axes) == ("dead_zone", ("gyro_y",))
    interval = one.parameters["width"]
    assert interval.low - (interval.high - interval.low) < width < interval.high + (interval.high - interval.low)
    (place,) = (place for place in discovery.discrepancies if place.view == "values")
    assert (place.axis, place.unit) == ("gyro_y", "rad/s")
    assert (place.low, place.high) == pytest.approx((-width / 2, width / 2), rel=1e-2)
    assert discovery.unexplained == ()
    assert any(isinstance(effect, DeadZone) for effect in discovery.final["gyro_y"])
    (density,) = (effect.density for effect in discovery.final["gyro_y"] if isinstance(effect, WhiteNoise))
    assert density == pytest.approx(1e-4, rel=0.05)  # of all samples, not of those outside of the zone
    assert discovery.distances["distribution"].after.value < discovery.distances["distribution"].before.value


@pytest.mark.parametrize(
    "flaw", [Resolution(2e-4), Saturation(2e-3), StuckSamples(0.01, 5.0)], ids=lambda effect: effect.name
)
def test_other_flaws_are_found_beside_it_and_without_it(flaw):
    for effects in ([flaw], [flaw, DeadZone(1e-3)]):
        record = prepare(recorded(4, *effects))
        assert {(one.name, one.axes) for one in record.findings} == {(one.name, ("gyro_y",)) for one in effects}


def test_a_dead_zone_of_the_start_model_is_no_news():
    start = ErrorModel({"gyro_y": AxisModel((WhiteNoise(1e-4), DeadZone(1e-3)))})
    record = prepare(recorded(5, DeadZone(1e-3)), start=start)
    assert record.findings == ()
