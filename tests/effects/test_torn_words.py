import numpy as np
import pytest
from tests.chance import as_often_as
from tests.effects.simulated import conditions

from imugap.discovery.device import Settings, discover
from imugap.effects import Outliers, Resolution, TornWords, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.log import from_samples
from imugap.stream import stream

COUNT, STEP = 20_000, 2e-4


def words(level, run=0, std=12.0):
    """Whole numbers of steps about a level, as floats."""
    return np.rint(level + std * stream(9, "words", run).standard_normal(COUNT))


def torn(values, probability=0.02, bits=8.0, run=0):
    effect = TornWords(probability, STEP, bits)
    return effect.apply(STEP * values, conditions(len(values)), stream(9, "torn", run))


def test_a_torn_word_has_the_high_bits_of_the_one_before():
    values = np.array([255.0, 256.0, 300.0, -1.0, -256.0, -257.0])
    found = TornWords(1.0, 1.0, 8.0).apply(values, conditions(6), stream(1))
    np.testing.assert_array_equal(found, [255.0, 0.0, 300.0, 511.0, -256.0, -1.0])


def test_words_whose_high_bits_stay_are_not_changed():
    values = words(128, std=15.0)
    np.testing.assert_array_equal(torn(values, 1.0), STEP * values)


def test_the_probability_is_in_its_interval_as_often_as_it_says():
    inside = []
    for run in range(60):
        found = TornWords.found(torn(words(255, run), run=run), conditions(COUNT))
        assert found.effect.bits == 8
        low, high = found.intervals["probability"]
        inside.append(low < 0.02 < high)
    assert as_often_as(inside, 0.95)


@pytest.mark.parametrize("level", [0.0, 256.0, -512.0])
def test_all_words_that_are_off_are_marked_and_no_other(level):
    values = words(level)
    found = TornWords.found(torn(values), conditions(COUNT))
    np.testing.assert_array_equal(found.flawed, torn(values) != STEP * values)


def test_the_offset_of_the_words_is_found():
    values = words(77)
    effect = TornWords(0.05, STEP, 8.0, 77 * STEP)
    found = TornWords.found(effect.apply(STEP * values, conditions(COUNT), stream(9, "offset")), conditions(COUNT))
    assert found.effect.offset == pytest.approx(77 * STEP, abs=2 * STEP)


def test_outliers_of_any_size_are_not_torn_words():
    for run in range(20):
        rng = stream(9, "outliers", run)
        values = STEP * np.rint(
            words(255, run) + np.where(rng.random(COUNT) < 0.01, 400 * rng.standard_normal(COUNT), 0)
        )
        assert TornWords.found(values, conditions(COUNT)) is None


def test_flips_of_one_bit_are_not_torn_words():
    values = words(40)
    flipped = stream(9, "flips").random(COUNT) < 0.01
    assert TornWords.found(STEP * np.where(flipped, values + 256, values), conditions(COUNT)) is None


def test_parts_are_torn_as_the_whole():
    values, at = STEP * words(255), conditions(COUNT)
    step = TornWords(0.1, STEP).in_parts(None, stream(9, "parts"))
    parts = np.concatenate([step(one, at) for one in np.split(values, [300, 301, 7000])])
    np.testing.assert_array_equal(parts, TornWords(0.1, STEP).apply(values, at, stream(9, "parts")))


def test_torn_words_are_named_and_not_taken_for_outliers():
    model = AxisModel((WhiteNoise(3e-4), Resolution(STEP), TornWords(0.03, STEP)))
    log = from_samples({"gyro_x": model.simulate(np.full(COUNT, 255 * STEP), conditions(COUNT), 3)}, 0.01)
    found = discover([log], Settings(replicates=20, simulations=10))
    assert {one.name for one in found.findings} == {"resolution", "torn_words"}
    assert found.distances["distribution"].after.value < found.distances["distribution"].floor.high
    assert not any(isinstance(one, Outliers) for one in found.final["gyro_x"])
