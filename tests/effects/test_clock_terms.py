import numpy as np
import pytest
from scipy.stats import binom
from tests.chance import as_often_as
from tests.effects.simulated import conditions, motion, sharp_std

from imugap import log
from imugap.effects import ClockScale, SampleLoss, TimestampJitter
from imugap.effects.effect import AxisModel
from imugap.integrity.timestamps import stamps
from imugap.stream import stream


def test_lost_samples_leave_the_others_with_their_stamps():
    table = motion(20_000)
    kept = SampleLoss(0.02, 5.0).keep(table, stream(11, "loss"))
    assert kept.equals(table.loc[kept.index])
    steps = np.rint(np.diff(kept.index) / 0.01)
    assert as_often_as(steps > 1, 0.02)
    gaps = steps[steps > 1] - 1
    assert gaps.mean() == pytest.approx(5.0, abs=4 * np.sqrt(5.0 * 4.0 / len(gaps)))


def test_a_loss_that_leaves_no_log_is_refused():
    with pytest.raises(ValueError, match="sample_loss: expected at least 2 samples that are left; found 1"):
        SampleLoss(1.0, 1e9).keep(motion(50), stream(11, "nothing"))


def test_jitter_displaces_stamps_by_its_deviation_and_no_sample():
    table = motion(5000)
    kept = TimestampJitter(5e-4).keep(table, stream(11, "jitter"))
    assert sharp_std(kept.index.to_numpy() - table.index.to_numpy(), 5e-4)
    np.testing.assert_array_equal(kept.to_numpy(), table.to_numpy())
    assert log.check(kept) is kept


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.002, 0.3])
def test_the_interval_of_a_jitter_in_ticks_holds_its_deviation(share):
    """A share of the stamps is a tick early or late: the fewer, the less is known of the deviation."""
    tick, held = 1e-4, 0
    for run in range(200):
        rng = stream(12, "ticks", run)
        ticks = rng.choice([-1, 0, 1], size=5000, p=[share / 2, 1 - share, share / 2])
        found = TimestampJitter.found(stamps(np.arange(5000) / 97.3 + tick * ticks))
        low, high = found.intervals["std"]
        held += low <= tick * np.sqrt(share) <= high
    assert binom.ppf(0.001, 200, 0.91) <= held < 200


@pytest.mark.parametrize("std", [0.01, 1.0])
def test_jitter_beyond_the_interval_keeps_the_order(std):
    kept = TimestampJitter(std).keep(motion(2000), stream(11, "order"))
    assert np.all(np.diff(kept.index) > 0)
    assert kept.index.name == "time"


class Still:
    """A source of "random" numbers that puts two stamps on the same place."""

    def standard_normal(self, count):
        return np.r_[1.0, 0.0, np.zeros(count - 2)]


def test_jitter_parts_stamps_that_coincide():
    table = log.from_samples({"gyro_x": np.arange(4.0)}, 1.0)
    kept = TimestampJitter(1.0).keep(table, Still())
    np.testing.assert_array_equal(kept.index, [1.0, np.nextafter(1.0, 2.0), 2.0, 3.0])


def test_clock_scale_multiplies_the_stamps_and_touches_no_sample():
    table = motion(100)
    kept = ClockScale(1.01).keep(table, stream(1))
    assert log.rate(kept) == pytest.approx(100 / 1.01)
    np.testing.assert_array_equal(kept.to_numpy(), table.to_numpy())
    assert kept.index.name == "time"


def test_samples_lost_on_one_axis_have_no_value():
    values = AxisModel((SampleLoss(0.1, 2.0),)).simulate(np.zeros(20_000), conditions(20_000), 1)
    share = 0.1 / (0.1 + 1 / 2.0)
    assert np.isnan(values).mean() == pytest.approx(share, abs=4 * np.sqrt(3 * share / 20_000))
    assert not values[~np.isnan(values)].any()


def test_samples_lost_on_one_axis_are_nan_there():
    kept = SampleLoss(0.1, 3.0).apply(np.ones(20_000), conditions(20_000), stream(8, "lost"))
    assert np.isnan(kept).mean() == pytest.approx(0.1 / (0.1 + 1 / 3), rel=0.1)
    assert np.all(kept[np.isfinite(kept)] == 1.0)
