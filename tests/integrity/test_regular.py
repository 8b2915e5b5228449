"""The rate is right for every clock that devices and drivers write, or the log is refused with its row."""

import numpy as np
import pandas as pd
import pytest

from imugap.integrity.regular import regular
from imugap.integrity.timestamps import stamps
from imugap.log import ACCEL, AXES, GYRO, TIME, LogError
from imugap.stream import stream

COUNT = 6000
RATES = [52.0, 100.0, 400.0, 1000.0]


def rng(*labels):
    return stream(50, "regular", *labels)


def even(rate, count=COUNT):
    return np.arange(count) / rate


def in_bursts(rate, size, within, jitter=0.0):
    row = np.arange(COUNT)
    return (row // size * size + row % size * within + jitter * rng("burst").standard_normal(COUNT)) / rate


def at_rest(count, interval, seed=1):
    """White noise of density 2e-4 and 2e-3, gravity on z."""
    values = rng("rest", seed).standard_normal((count, 6)) * np.repeat([2e-4, 2e-3], 3) / np.sqrt(interval)
    values[:, 5] -= 9.80665
    return values


def table(time, values=None):
    values = at_rest(len(time), float(np.median(np.diff(time)))) if values is None else values
    return pd.DataFrame(values, columns=list(AXES), index=pd.Index(time, name=TIME))


def densities(found):
    return {name: float(np.nanstd(one.values) * np.sqrt(one.interval)) for name, one in found.samples.items()}


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("size", [2, 3, 4, 8, 10])
@pytest.mark.parametrize(("within", "jitter"), [(0.0, 0.0), (0.2, 0.0), (0.2, 0.02), (0.5, 0.05)])
def test_every_row_of_a_packet_is_a_sample(rate, size, within, jitter):
    found = stamps(in_bursts(rate, size, within, jitter))
    assert found.interval * rate == pytest.approx(1, abs=1e-3)
    assert not found.lost.any()


@pytest.mark.parametrize("rate", RATES)
def test_packets_of_any_size_stamped_on_arrival_are_whole(rate):
    sizes = rng("sizes").integers(1, 6, COUNT)
    arrival = np.repeat(np.cumsum(sizes), sizes)[:COUNT]
    found = stamps((arrival + 0.05 * rng("within").random(COUNT)) / rate)
    assert found.interval * rate == pytest.approx(1, abs=2e-3)
    assert found.lost.mean() < 1e-3


@pytest.mark.parametrize("digits", [3, 6])
@pytest.mark.parametrize("rate", [52.0, 400.0, 1600.0])
def test_coarse_stamps_keep_the_rate(rate, digits):
    found = stamps(np.round(even(rate), digits))
    assert found.interval * rate == pytest.approx(1, abs=1e-3)
    assert not found.lost.any()


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("share", [0.01, 0.2, 0.4, 0.6, 0.8])
@pytest.mark.parametrize("jitter", [0.0, 0.05])
def test_lost_rows_leave_gaps_on_the_true_grid(rate, share, jitter):
    kept = rng("lost", rate).random(COUNT) > share
    kept[[0, -1]] = True
    time = even(rate) + jitter / rate * rng("jitter").standard_normal(COUNT)
    found = stamps(time[kept])
    assert found.count == COUNT
    np.testing.assert_array_equal(found.lost, ~kept)
    assert found.interval * rate == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("every", [3, 5])
def test_a_row_lost_at_equal_distances_is_a_gap(every):
    kept = np.arange(COUNT) % every != every - 1
    found = stamps(even(100.0)[kept])
    assert found.interval == pytest.approx(0.01)
    assert found.lost.mean() == pytest.approx(1 / every, abs=1e-3)


def test_lost_packets_are_gaps_of_their_size():
    row, lost = np.arange(COUNT), np.repeat(rng("packets").random(COUNT // 4) < 0.1, 4)
    found = stamps(((row // 4 * 4 + row % 4 * 0.2) / 200)[~lost])
    assert found.interval == pytest.approx(0.005, rel=1e-3)
    assert np.count_nonzero(found.lost) == pytest.approx(np.count_nonzero(lost), abs=4)


@pytest.mark.parametrize("time", [even(20.0), in_bursts(20.0, 4, 0.2), np.repeat(even(10.0, COUNT // 2), 2)])
def test_a_pause_of_an_hour_stays_an_hour(time):
    time = np.where(np.arange(COUNT) < COUNT // 2, time, time + 3600)
    found = stamps(time)
    assert found.interval == pytest.approx(0.05, rel=1e-3)
    assert np.count_nonzero(found.lost) == pytest.approx(72000, abs=4)


@pytest.mark.parametrize(
    ("bits", "unit", "name"),
    [(32, 1e-6, "2^32 us"), (32, 1e-9, "2^32 ns"), (16, 1e-3, "2^16 ms"), (16, 1e-4, "2^16 0.1 ms")],
)
@pytest.mark.parametrize("share", [0.0, 0.3])
def test_a_counter_that_wraps_is_named_and_unwrapped(bits, unit, name, share):
    count = 20000
    ticks = 2**bits - round(30 / unit) + np.round(even(100.0, count) / unit)
    kept = rng("wrap").random(count) >= share
    found = stamps((ticks % 2**bits * unit)[kept])
    assert found.interval == pytest.approx(0.01, rel=1e-4)
    assert any(name in remark for remark in found.remarks)


def test_a_run_that_begins_anew_is_refused_at_its_row():
    time = np.r_[500 + even(100.0), even(100.0)]
    with pytest.raises(LogError, match=rf"line {COUNT + 2}, column time: .*another run begins there"):
        stamps(time, lambda row: f"line {row + 2}")


@pytest.mark.parametrize("step", [-0.3, -0.05])
def test_a_clock_that_is_set_back_goes_on_evenly(step):
    time = even(100.0) + np.where(np.arange(COUNT) > 2500, step, 0.0)
    found = stamps(time)
    assert found.interval == pytest.approx(0.01, rel=1e-4)
    assert found.count == COUNT
    assert "set back once, at row 2501" in str(found.remarks[0])


@pytest.mark.parametrize("jitter", [0.0, 0.05])
def test_another_rate_is_refused_at_its_row(jitter):
    steps = np.r_[np.full(COUNT // 2, 0.01), np.full(COUNT // 2, 0.008)]
    time = np.cumsum(steps) + jitter * 0.01 * rng("rates").standard_normal(COUNT)
    with pytest.raises(LogError, match=r"row (29\d\d|30\d\d), column time: expected one rate; found 100 Hz before"):
        stamps(time)


@pytest.mark.parametrize("shape", [1.0, 4.0])
def test_samples_at_random_times_have_no_rate(shape):
    with pytest.raises(LogError, match="from which no rate follows"):
        stamps(np.cumsum(rng("poisson").gamma(shape, 0.01 / shape, COUNT)))


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("jitter", [0.0, 0.02, 0.2])
def test_a_sound_log_comes_back_as_it_is(rate, jitter):
    whole = table(even(rate) + jitter / rate * rng("sound").uniform(-1, 1, COUNT))
    found = regular(whole)
    assert found.log is whole
    assert not found.remarks
    assert {name: len(one.values) for name, one in found.samples.items()} == dict.fromkeys(AXES, COUNT)


def test_rows_written_twice_are_left_out():
    time = even(100.0)
    whole = table(time)
    again = pd.concat([whole.iloc[:3000], whole.iloc[2900:]])
    found = regular(again)
    np.testing.assert_array_equal(found.samples["gyro_x"].values, whole["gyro_x"])
    assert str(found.remarks[0]) == "100 rows written twice, first at row 3000: left out"


def test_pairs_on_a_coarse_lattice_are_no_rows_written_twice():
    values = np.round(rng("coarse").standard_normal((COUNT, 1)) * 0.5)
    log = pd.DataFrame(values, columns=["gyro_x"], index=pd.Index(np.repeat(even(50.0, COUNT // 2), 2), name=TIME))
    found = regular(log)
    assert len(found.samples["gyro_x"].values) == COUNT
    assert found.interval == pytest.approx(0.01, rel=1e-3)


@pytest.mark.parametrize("rows", [2, 4, 4.5, 1.25])
def test_held_values_are_counted_once(rows):
    slow = at_rest(4000, 0.01)
    held = slow[(np.arange(int(4000 * rows)) / rows).astype(int)]
    found = regular(table(np.arange(len(held)) * 0.01 / rows, held))
    assert found.samples["gyro_y"].interval == pytest.approx(0.01, rel=1e-3)
    assert densities(found)["gyro_y"] == pytest.approx(2e-4, rel=0.05)
    assert densities(found)["accel_x"] == pytest.approx(2e-3, rel=0.05)
    assert "repeat between samples at 100 Hz" in str(found.remarks[0])


@pytest.mark.parametrize("slow", [125.0, 250.0, 320.0, 360.0])
def test_values_between_slower_samples_are_averaged(slow):
    count = 60000
    whole = at_rest(count, 1 / 400)
    own = at_rest(int(count * slow / 400) + 9, 1 / slow, 2)
    for column in (3, 4, 5):
        whole[:, column] = np.interp(even(400.0, count), even(slow, len(own)) - 0.0007, own[:, column])
    found = regular(table(even(400.0, count), whole))
    assert found.samples["gyro_x"].interval == pytest.approx(1 / 400)
    assert densities(found)["accel_y"] == pytest.approx(2e-3, rel=0.08)
    assert f"interpolated between samples at {slow:g} Hz" in str(found.remarks[0])


@pytest.mark.parametrize("tone", [0.0, 0.17, 0.31])
@pytest.mark.parametrize("kind", ["white", "filtered", "coarse"])
def test_sound_noise_and_vibration_are_neither_held_nor_interpolated(kind, tone):
    values = rng("noise", kind).standard_normal((COUNT, 6))
    if kind == "filtered":
        values = np.apply_along_axis(np.convolve, 0, values, np.ones(4) / 4, "same")
    values += 3 * np.sin(2 * np.pi * tone * np.arange(COUNT))[:, None]
    if kind == "coarse":
        values = np.round(values * 0.5)
    assert not regular(table(even(200.0), values)).remarks


@pytest.mark.parametrize("period", [6.0, 30.0, 55.0, 3000.0])
@pytest.mark.parametrize("taps", [1, 5])
def test_motion_that_comes_and_goes_is_not_interpolated(period, taps):
    beat = np.sin(np.pi * np.arange(COUNT) / period) ** 8
    values = (0.01 + beat[:, None]) * rng("gait", period).standard_normal((COUNT, 6))
    values = np.apply_along_axis(np.convolve, 0, values, np.hanning(taps + 2), "same")
    assert not regular(table(even(100.0), values)).remarks


@pytest.mark.parametrize("level", [0.0, 0.3, np.nan])
def test_a_dead_axis_costs_that_axis_alone(level):
    whole = table(even(100.0))
    whole["gyro_z"] = level
    found = regular(whole)
    assert set(found.samples) == set(AXES) - {"gyro_z"}
    assert list(found.unusable) == ["gyro_z"]
    assert densities(found)["gyro_x"] == pytest.approx(2e-4, rel=0.05)


def test_two_streams_in_one_file_keep_their_own_stamps():
    gyro, accel = table(even(200.0)), table(even(125.0, 3750) + 0.0011)
    gyro.iloc[:, 3:], accel.iloc[:, :3] = np.nan, np.nan
    found = regular(pd.concat([gyro, accel]).sort_index())
    assert found.samples["gyro_x"].interval == pytest.approx(1 / 200)
    assert found.samples["accel_x"].interval == pytest.approx(1 / 125)
    assert densities(found)["gyro_x"] == pytest.approx(2e-4, rel=0.05)
    assert densities(found)["accel_x"] == pytest.approx(2e-3, rel=0.05)


def test_values_without_power_or_not_finite_are_lost():
    whole = table(even(100.0))
    whole.iloc[:50] = 0.0
    whole.iloc[3000:3020] = 0.0
    whole.iloc[4000, 4] = np.inf
    found = regular(whole)
    assert np.count_nonzero(found.samples["gyro_x"].lost) == 70
    assert np.count_nonzero(found.samples["accel_y"].lost) == 71
    assert tuple(map(str, found.remarks)) == (
        "70 rows zero on all axes, first at row 0: lost",
        "values empty or not finite, first at row 4000: accel_y 1: lost",
    )


@pytest.mark.parametrize("shares", [[0.05, 0.02, 0, 0, 0, 0], [0.2, 0, 0, 0, 0, 0], [0.2, 0.25, 0.05, 0, 0, 0.3]])
def test_values_lost_at_random_are_counted_and_are_no_stream_of_their_own(shares):
    values = at_rest(COUNT, 0.01)
    values[rng("lost", *map(str, shares)).random(values.shape) < shares] = np.nan
    found = regular(table(even(100.0), values))
    counts = {name: int(n) for name, n in zip(AXES, np.isnan(values).sum(axis=0), strict=True) if n}
    first = int(np.flatnonzero(np.isnan(values).any(axis=1))[0])
    each = ", ".join(f"{name} {n}" for name, n in counts.items())
    assert [str(one) for one in found.remarks] == [f"values empty or not finite, first at row {first}: {each}: lost"]
    assert len(found.streams) == 1
    np.testing.assert_array_equal(found.log.to_numpy(), values)


@pytest.mark.parametrize("every", [2, 4])
def test_a_slower_sensor_on_the_same_stamps_is_a_stream(every):
    values = at_rest(COUNT, 0.01)
    values[np.arange(COUNT) % every > 0, 3:] = np.nan
    found = regular(table(even(100.0), values))
    assert len(found.streams) == 2
    assert found.samples["accel_z"].interval == pytest.approx(0.01 * every)


def test_seconds_that_many_rows_share_are_refused_with_the_option():
    with pytest.raises(LogError, match=r"--rate HZ.*found 120 different stamps in 119 s, most 1 s apart"):
        regular(table(np.floor(even(50.0)), at_rest(COUNT, 0.02)))


def test_two_recordings_days_apart_are_refused_at_the_pause():
    time = even(50.0)
    time[COUNT // 2 :] += 2 * 86400
    with pytest.raises(LogError, match=r"split the file there.*found no row from 59.98 to 172860 s"):
        regular(table(time))


def test_a_triad_without_any_value_is_unusable():
    empty = table(even(100.0)).assign(**dict.fromkeys(ACCEL, np.nan))
    assert set(regular(empty).unusable) == set(ACCEL)


@pytest.mark.parametrize("noise", [1.0, 2**0.5])
def test_half_the_rate_at_the_same_noise_is_loss_and_at_other_noise_another_rate(noise):
    kept = (np.arange(2 * COUNT) < COUNT) | (np.arange(2 * COUNT) % 2 == 0)
    values = at_rest(2 * COUNT, 0.01)
    values[COUNT:] = values[COUNT:] / noise
    log = table(even(100.0, 2 * COUNT)[kept], values[kept])
    if noise == 1:
        assert regular(log).interval == pytest.approx(0.01)
    else:
        with pytest.raises(LogError, match="expected one rate; found 100 Hz before it and 50 Hz from it on"):
            regular(log)


def test_samples_that_all_axes_have_come_once_and_in_time():
    whole = table(even(100.0))
    pd.testing.assert_frame_equal(regular(whole).measured, whole)
    dropped = whole.drop(whole.index[[100, 101, 300]])
    pd.testing.assert_frame_equal(regular(dropped).measured, dropped, check_exact=False, rtol=1e-12)
    held = table(even(400.0, 4 * COUNT), np.repeat(whole.to_numpy(), 4, axis=0))
    np.testing.assert_array_equal(regular(held).measured["gyro_z"], whole["gyro_z"])


def test_navigation_needs_every_axis():
    whole = table(even(100.0))
    whole["gyro_z"] = 0.0
    with pytest.raises(LogError, match="expected values on every axis; found gyro_z: 0 throughout"):
        _ = regular(whole).measured


def test_a_stuck_stretch_is_not_taken_for_interpolated_values():
    values = stream(77, "stuck stretch").standard_normal(20_000)
    values[5000:10_000] = values[5000]
    table = pd.DataFrame({"gyro_x": values}, index=pd.Index(0.02 * np.arange(20_000), name="time"))
    found = regular(table)
    assert len(found.samples["gyro_x"].values) == 20_000
    assert found.remarks == ()


@pytest.mark.parametrize("accel_hz", [100.0, 80.0, 160.0])
def test_streams_with_stamps_of_their_own_are_joined_at_the_stamps_of_the_fastest(accel_hz):
    def course(time):
        return np.sin(2 * np.pi * time)[:, None] * [1.0, 2.0, 3.0]

    gyro, accel = np.arange(2000) / 100, 0.0033 + np.arange(int(20 * accel_hz)) / accel_hz
    noise = stream(3, "streams").normal(0, 1e-3, (len(gyro) + len(accel), 3))
    rates = pd.DataFrame(course(gyro) + noise[: len(gyro)], index=gyro, columns=list(GYRO))
    forces = pd.DataFrame(course(accel) + noise[len(gyro) :], index=accel, columns=list(ACCEL))
    forces = forces[(accel < 5) | (accel > 5.2)]
    joined = regular(pd.concat([rates, forces]).sort_index()).measured
    assert tuple(joined.columns) == (*GYRO, *ACCEL)
    assert 1 / np.median(np.diff(joined.index)) == pytest.approx(max(accel_hz, 100), rel=1e-3)
    assert not ((joined.index > 5.01) & (joined.index < 5.19)).any()
    assert joined.index[0] >= 0.0033
    np.testing.assert_allclose(joined[list(GYRO)], course(joined.index.to_numpy()), atol=8e-3)
    np.testing.assert_allclose(joined[list(ACCEL)], course(joined.index.to_numpy()), atol=8e-3)


def test_a_clock_set_back_by_an_hour_goes_on_and_that_is_said():
    time = 1_729_990_000 + even(100.0) - np.where(np.arange(COUNT) < COUNT // 2, 0, 3600)
    found = stamps(time)
    assert found.interval == pytest.approx(0.01, rel=1e-4)
    assert found.count == COUNT
    assert f"set back once, at row {COUNT // 2}, by an hour (end of daylight saving?)" in str(found.remarks[0])


def test_a_run_of_an_hour_behind_another_is_refused():
    with pytest.raises(LogError, match="another run begins there"):
        stamps(np.tile(np.arange(7200) / 2, 2))


def test_a_clock_set_ahead_by_an_hour_at_a_whole_hour_goes_on_and_that_is_said():
    begin = 1_774_746_000
    time = begin - 30 + even(100.0)
    found = stamps(time + 3600.0 * (time >= begin))
    assert found.interval == pytest.approx(0.01, rel=1e-4)
    assert found.count == COUNT
    assert "set ahead at row 3000, by an hour (begin of daylight saving?)" in str(found.remarks[0])


@pytest.mark.parametrize("begin", [-30.3, 100.0])
def test_a_pause_of_an_hour_at_another_time_stays_a_pause(begin):
    time = 1_774_746_000 + begin + even(50.0)
    time[COUNT // 2 :] += 3600.0
    assert stamps(time).count == COUNT + 180_000


def test_a_gap_in_the_middle_longer_than_the_excerpt_is_no_error():
    time = even(50.0)
    time[COUNT // 2 :] += 3600.0
    found = regular(table(time))
    assert found.measured[AXES[0]].notna().sum() == COUNT
