import numpy as np
import pandas as pd
import pytest
from scipy.signal import butter, lfilter
from scipy.stats import binom

from imugap import log
from imugap.discovery.preparation.prepare import MARGIN, prepare
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects import Bias, Resolution, SampleLoss, Saturation, StuckSamples, TimestampJitter, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.log import LogError
from imugap.model import ErrorModel
from imugap.numerics.samples.random_runs import simulate_runs
from imugap.stream import stream

SD = 0.1
NOISE = WhiteNoise(SD * 0.1)
"""Deviation 0.1 at 100 Hz."""


def still(count, axes=("gyro_x",), interval=0.01):
    return log.from_samples({axis: np.zeros(count) for axis in axes}, interval)


def device(*effects, clock=(), axes=("gyro_x",)):
    """Noise and effects, the same on all axes."""
    return ErrorModel({axis: AxisModel((NOISE, *effects)) for axis in axes} | {"time": AxisModel(clock)})


def prepared(*effects, clock=(), axes=("gyro_x",), count=5000, seed=1):
    return prepare(device(*effects, clock=clock, axes=axes).simulate(still(count, axes), seed, "record"))


def names(record):
    """The effects that are named, with their axes."""
    return {(axis, effect.name) for found in record.findings for axis, effect in found.effects.items()}


def parameters(record, name):
    """The parameters of the one finding of a name."""
    (finding,) = [found for found in record.findings if next(iter(found.effects.values())).name == name]
    return finding.parameters


COLOURS = ("white", "walk", "flicker", "filtered", "swing", "tailed", "uniform")


def coloured(kind, count, rng):
    """Noise of unit deviation or so without any flaw."""
    white = rng.standard_normal(count)
    if kind == "walk":
        return white + rng.choice([0.01, 0.05, 0.2]) * np.cumsum(rng.standard_normal(count))
    if kind == "flicker":
        shape = np.sqrt(np.r_[1.0, np.fft.rfftfreq(2 * count)[1:]])
        slow = np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * count)) / shape)[:count]
        return white + slow / slow.std()
    if kind == "filtered":
        low = lfilter(*butter(2, rng.choice([0.1, 0.3, 0.6])), white)
        return low / low.std()
    if kind == "swing":
        return 0.3 * white + 3 * np.sin(2 * np.pi * rng.uniform(0.001, 0.2) * np.arange(count))
    return {"tailed": rng.standard_t(5, count), "uniform": rng.uniform(-1, 1, count)}.get(kind, white)


def written(values, rng):
    """The values as a device or a file rounds them, and the step if it is none of the file."""
    form = rng.choice(["as they are", "lattice", "decimals", "digits", "degrees", "single"])
    if form == "lattice":
        step = rng.uniform(0.3, 3.0) * values.std()
        return step * np.rint(values / step), step
    if form == "degrees":
        step = np.radians(rng.choice([1e-3, 1 / 16.4, 1 / 131, 0.05]))
        return step * np.rint(values / step), step
    if form == "decimals":
        digits = int(rng.integers(3, 10))
        return np.round(values, digits), 10.0**-digits
    if form == "digits":
        digits = int(rng.integers(4, 10))
        step = 10.0 ** (np.floor(np.log10(np.abs(values).max())) - digits + 1)
        return np.array([float(f"{value:.{digits - 1}e}") for value in values]), step
    return (values.astype(np.float32).astype(float) if form == "single" else values), 0.0


def ticking(count, rng):
    """Stamps of an even clock as a device or a file rounds them."""
    interval = 1 / rng.choice([50, 100, 104, 119, 200, 249.756, 400, 800, 952])
    time = interval * np.arange(count)
    forms = {
        "exact": lambda: time,
        "summed": lambda: np.cumsum(np.full(count, interval)),
        "decimals": lambda: np.round(time, int(rng.integers(3, 10))),
        "ticks": lambda: np.round(np.rint(time * 32768) / 32768, int(rng.choice([6, 9]))),
        "single": lambda: time.astype(np.float32).astype(float),
        "epoch": lambda: 1.7e9 + time,
    }
    return forms[rng.choice(list(forms))]()


def healthy(*labels):
    """A log with nothing hidden, and the steps of its axes."""
    rng = stream(9, "healthy", *labels)
    count, columns, steps = int(rng.choice([2000, 5000])), {}, {}
    for axis in rng.choice(log.AXES, 2, replace=False):
        values = coloured(rng.choice(COLOURS), count, rng) * 10 ** rng.uniform(-3, 0) + rng.choice([0.0, 0.3, -9.81])
        columns[axis], steps[axis] = written(values, rng)
    table = pd.DataFrame(columns, index=pd.Index(ticking(count, rng), name="time"))
    return table[[axis for axis in log.AXES if axis in columns]], steps


def holding(found, **truth):
    """The number of parameters whose interval holds the truth."""
    return sum(found[name].low < value < found[name].high for name, value in truth.items())


def stuck_rows(table, length, seed):
    """The log with all axes stuck together, in a thousandth of the samples for a mean length."""
    stuck = simulate_runs(len(table), 1e-3, length, stream(seed, "held"))
    rows = np.maximum.accumulate(np.where(stuck, 0, np.arange(len(table))))
    return table.iloc[rows].set_axis(table.index)


def parameters_of(record, axis):
    return next(found.effects[axis] for found in record.findings if axis in found.effects)


@pytest.mark.slow
@pytest.mark.parametrize(("cases", "least"), [(range(120), 20), (range(120, 1120), 200)], ids=["few", "a thousand"])
def test_nothing_is_named_where_nothing_is_hidden(cases, least):
    """No name but that of a lattice that is there, no discrepancy of the stamps."""
    named = 0
    for case in cases:
        table, steps = healthy(case)
        record = prepare(table)
        for axis, name in names(record):
            assert name == "resolution", (case, axis, name)
            assert parameters_of(record, axis).step == pytest.approx(steps[axis], rel=1e-3), (case, axis)
            named += 1
        assert not [place for place in record.discrepancies if place.view == "stamps"], case
    assert named > least


CASES = 100
LEAST = int(binom.ppf(1e-4, CASES, 0.95))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "width"),
    [
        (StuckSamples(0.02, 3.0), 0.5),
        (StuckSamples(0.01, 1.0), 0.6),
        (SampleLoss(0.02, 3.0), 0.5),
        (TimestampJitter(1e-3), 0.05),
        (TimestampJitter(2e-3), 0.05),
    ],
    ids=["stuck", "single", "loss", "jitter", "strong jitter"],
)
def test_intervals_hold_the_truth_and_are_no_wider_than_they_must(effect, width):
    hits, widths = dict.fromkeys(effect.parameters(), 0), dict.fromkeys(effect.parameters(), 0.0)
    clock = effect.stage > StuckSamples.stage
    for case in range(CASES):
        record = prepared(*(() if clock else (effect,)), clock=(effect,) if clock else (), seed=100 + case)
        found = parameters(record, effect.name)
        assert {name for _, name in names(record)} == {effect.name}
        for key, value in effect.parameters().items():
            hits[key] += found[key].low <= value <= found[key].high
            widths[key] += (found[key].high - found[key].low) / value / CASES
    assert min(hits.values()) >= LEAST
    assert max(widths.values()) < width


def test_a_resolution_is_exact_and_fine_decimals_are_the_file():
    for step in (0.03, 0.0873, 0.3):
        assert parameters(prepared(Resolution(step)), "resolution")["step"].value == pytest.approx(step, rel=1e-6)
    table = device().simulate(still(5000), 3).round(3)
    assert names(prepare(table)) == set()  # 0.001 is a hundredth of the deviation


def test_a_lattice_written_as_decimals_is_still_one():
    table = device(Resolution(np.radians(0.5))).simulate(still(5000), 3).round(6)
    found = parameters(prepare(table), "resolution")["step"]
    assert found.value == pytest.approx(np.radians(0.5), rel=1e-4)
    assert found.low < np.radians(0.5) < found.high


@pytest.mark.parametrize("step", [None, 0.02])
@pytest.mark.parametrize("offset", [0.0, 0.15])
def test_a_full_scale_is_found_on_one_side_or_both(step, offset):
    lattice = () if step is None else (Resolution(step),)
    record = prepared(Bias(offset), Saturation(0.18), *lattice)
    assert ("gyro_x", "saturation") in names(record)
    assert "stuck_samples" not in {name for _, name in names(record)}
    assert parameters(record, "saturation")["limit"].value == pytest.approx(0.18, rel=1e-9)
    assert np.abs(record.sequences["gyro_x"].values).max() > 0.2


@pytest.mark.parametrize("held", [1, 2])
def test_the_top_of_the_motion_that_falls_short_of_it_is_a_full_scale(held):
    """Whether one sample is cut off or two, which also look like one that is stuck."""
    time = 0.04 * np.arange(9000)
    rate = 0.3 + np.sin(2 * np.pi * 1.7 * time) * (1 + 0.3 * np.exp(-(((time - 140.62) / 0.3) ** 2)))
    ideal = pd.DataFrame({"gyro_x": rate}, index=pd.Index(time, name="time"))
    noise = 1e-4 * stream(1, "short").standard_normal(len(time))
    limit = np.sort(rate)[-held - 1 : -held + 1 or None].mean()
    record = prepare(pd.DataFrame({"gyro_x": np.clip(rate + noise, -limit, limit)}, index=ideal.index), ideal)
    assert [name for _, name in names(record)] == ["saturation"]
    assert parameters(record, "saturation")["limit"].value == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize("limit", [0.06, 0.12, 0.18])
def test_what_is_clipped_biases_neither_mean_nor_spread(limit):
    clipped, free = prepared(Bias(0.05), Saturation(limit)), prepared(Bias(0.05))
    sequence, truth = clipped.sequences["gyro_x"].values, free.sequences["gyro_x"].values
    assert np.mean(np.abs(clipped.outputs["gyro_x"]) == limit) > 0.08
    assert sequence.mean() == pytest.approx(truth.mean(), abs=0.06 * SD)
    assert sequence.std() == pytest.approx(truth.std(), rel=0.06)
    assert abs(np.corrcoef(sequence[1:], sequence[:-1])[0, 1]) < 0.07


def test_clipped_samples_of_a_coarse_lattice_stay():
    values = np.zeros(1000)
    values[::10], values[5::50] = 1.0, 2.0
    conditions = Conditions(0.01 * np.arange(1000), 0.01)
    sequence = AxisSequence(values, conditions, values == 2.0)
    low = np.where(values == 2.0, 2.0, -np.inf)
    drawn = sequence.with_censored_drawn(low, np.full(len(values), np.inf), stream(1, "coarse"))
    np.testing.assert_array_equal(drawn.values, values)
    assert drawn.flawed.sum() == 20


def test_a_motion_far_beyond_the_full_scale_tells_nothing_of_the_error():
    time = 0.01 * np.arange(5000)
    moving = log.from_samples({"gyro_x": 3 * np.sin(2 * time)}, 0.01)
    sequence = prepare(device(Saturation(2.0)).simulate(moving, 1), moving).sequences["gyro_x"]
    far = np.abs(moving["gyro_x"].to_numpy()[MARGIN:-MARGIN]) > 2.0 + 8 * SD
    assert sequence.flawed[far].all()
    assert sequence.values[far].std() < 1.3 * SD
    assert abs(sequence.values[far].mean()) < 0.3 * SD


@pytest.mark.parametrize("step", [None, 0.02])
def test_stuck_samples_are_marked_and_replaced(step):
    lattice = () if step is None else (Resolution(step),)
    record = prepared(StuckSamples(0.005, 20.0), *lattice)
    sequence = record.sequences["gyro_x"]
    assert ("gyro_x", "stuck_samples") in names(record)
    assert 0.05 < sequence.flawed.mean() < 0.14  # 0.091
    assert np.mean(np.diff(sequence.values) == 0) < (0.001 if step is None else 0.08)


@pytest.mark.parametrize("reference", [False, True])
def test_the_output_is_kept_as_it_is_but_for_what_was_lost(reference):
    ideal = log.from_samples({"gyro_x": 0.01 * np.sin(np.arange(5000))}, 0.01)
    measured = device(Saturation(0.18), StuckSamples(0.005, 20.0)).simulate(ideal, 3, "record")
    measured["gyro_y"] = stream(3, "other").normal(0.0, SD, 5000)
    ideal["gyro_y"] = 0.0
    lost = np.zeros(5000, bool)
    lost[100:1000:50] = True
    record = prepare(measured.assign(gyro_x=measured["gyro_x"].mask(lost)), ideal if reference else None)
    kept, used = record.outputs["gyro_x"], slice(MARGIN, -MARGIN) if reference else slice(None)
    lost, measured = lost[used], measured[used]
    np.testing.assert_array_equal(kept[~lost], measured["gyro_x"][~lost])
    assert np.abs(kept[lost]).max() < 5 * SD
    assert {"saturation", "stuck_samples", "sample_loss"} <= {name for _, name in names(record)}


def of_steps(values, step=1e-3):
    """A log of one axis of values in steps of its lattice."""
    return log.from_samples({"gyro_x": step * values}, 0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("size", "louder"), [(0.2, 6.0), (0.5, 6.0), (0.8, 4.0)])
def test_what_a_coarse_lattice_repeats_is_not_stuck_though_the_noise_is_louder_for_a_while(size, louder):
    for seed in range(30):
        noise = size * stream(seed, "louder").standard_normal(4000)
        noise[1000:1500] *= louder
        assert names(prepare(of_steps(np.rint(noise), 1e-4))) == {("gyro_x", "resolution")}


@pytest.mark.slow
@pytest.mark.parametrize("deviation", [4.0, 8.0])
def test_what_a_converter_without_some_codes_repeats_is_not_stuck(deviation):
    for seed in range(10):
        rng = stream(seed, "codes")
        codes = np.rint(deviation * rng.standard_normal(30_000))
        codes += np.isin(codes, rng.choice(np.unique(codes), len(np.unique(codes)) // 4, replace=False))
        assert names(prepare(of_steps(codes, 1e-4))) == {("gyro_x", "resolution")}


@pytest.mark.parametrize(("cutoff", "order", "size"), [(0.08, 2, 6.0), (0.14, 4, 6.0), (0.04, 2, 10.0), (0.3, 4, 3.3)])
def test_what_a_smooth_signal_repeats_where_it_turns_is_not_stuck(cutoff, order, size):
    smooth = lfilter(*butter(order, cutoff), stream(1, "smooth").standard_normal(100_000))
    record = prepare(of_steps(np.rint(size * smooth / smooth.std()), 1e-4))
    assert names(record) == {("gyro_x", "resolution")}


def hand(seed, deviation=0.8, axis="gyro_x", period=60, count=30_000):
    """A motion of a hand that rests for a while in every period, and what a device on a coarse lattice makes of it."""
    rng, time = stream(seed, "hand", axis), 0.01 * np.arange(count)
    turns = np.sin(2 * np.pi * rng.uniform(0.1, 2.0, (6, 1)) * time + rng.uniform(0, 6, (6, 1))).sum(axis=0)
    ideal = 100 * turns * np.where(np.sin(2 * np.pi * time / period) > 0.3, 0.02, 1.0)
    return ideal, np.rint(ideal + deviation * rng.standard_normal(count))


def test_what_a_coarse_lattice_repeats_while_a_motion_is_slow_is_not_stuck():
    for seed in range(10):
        ideal, values = hand(seed)
        assert names(prepare(of_steps(values), of_steps(ideal))) == {("gyro_x", "resolution")}


@pytest.mark.slow
def test_what_axes_repeat_while_all_of_them_rest_is_not_stuck():
    for seed in range(10):
        axes = {axis: hand(seed, 2.5, axis, 2) for axis in ("gyro_x", "gyro_y", "gyro_z")}
        ideal, values = (log.from_samples({axis: 1e-3 * pair[k] for axis, pair in axes.items()}, 0.01) for k in (0, 1))
        assert {name for _, name in names(prepare(values, ideal))} == {"resolution"}


@pytest.mark.slow
def test_what_sticks_on_all_axes_is_found_in_motion():
    held, axes = 0, ("gyro_x", "gyro_y", "gyro_z")
    for seed in range(8):
        pairs = {axis: hand(seed, 1.7, axis) for axis in axes}
        ideal, values = (log.from_samples({axis: 1e-3 * pair[k] for axis, pair in pairs.items()}, 0.01) for k in (0, 1))
        record = prepare(stuck_rows(values, 4.0, seed), ideal)
        found = parameters(record, "stuck_samples")
        assert {axis for axis, name in names(record) if name == "stuck_samples"} == set(axes)
        held += holding(found, probability=1e-3, length=4.0)
    assert held >= binom.ppf(1e-3, 16, 0.95)


@pytest.mark.slow
def test_what_sticks_on_all_axes_is_found_where_some_lattices_are_too_coarse_to_tell():
    held, deviations = 0, {"gyro_x": 0.9, "gyro_y": 1.7, "gyro_z": 0.4, "accel_x": 2.0, "accel_y": 3.0, "accel_z": 0.45}
    for seed in range(8):
        noise = {axis: size * stream(seed, axis).standard_normal(60_000) for axis, size in deviations.items()}
        values = log.from_samples({axis: 1e-3 * np.rint(one) for axis, one in noise.items()}, 0.01)
        assert {name for _, name in names(prepare(values))} == {"resolution"}
        record = prepare(stuck_rows(values, 6.0, seed))
        found = parameters(record, "stuck_samples")
        assert {axis for axis, name in names(record) if name == "stuck_samples"} == set(deviations)
        held += holding(found, probability=1e-3, length=6.0)
    assert held >= binom.ppf(1e-3, 16, 0.95)


def test_what_sticks_while_a_motion_is_fast_is_found_on_a_coarse_lattice():
    held = 0
    for seed in range(10):
        ideal, values = hand(seed)
        stuck = StuckSamples(2e-3, 5.0).apply(values, Conditions(np.arange(len(values)), 1.0), stream(seed, "held"))
        found = parameters(prepare(of_steps(stuck), of_steps(ideal)), "stuck_samples")
        held += holding(found, probability=2e-3, length=5.0)
    assert held >= binom.ppf(1e-3, 20, 0.95)


@pytest.mark.parametrize("curve", ["line", "ramp", "step"])
def test_values_without_noise_are_looked_at_all_the_same(curve):
    time = 0.01 * np.arange(4000)
    values = {"line": np.sin(2 * np.pi * 3 * time), "ramp": time, "step": (time > 20) * 1.0}[curve]
    record = prepare(log.from_samples({"gyro_x": values}, 0.01))
    assert all(place.p_value < 1e-6 for place in record.discrepancies)


def test_repeats_of_all_axes_at_once_are_one_finding():
    axes = ("gyro_x", "gyro_y", "accel_z")
    table = device(Resolution(0.03), axes=axes).simulate(still(5000, axes), 4)
    rows = np.arange(len(table))
    rows[1::100] -= 1
    record = prepare(table.iloc[rows].set_axis(table.index))
    found = parameters(record, "stuck_samples")
    assert {axis for axis, name in names(record) if name == "stuck_samples"} == set(axes)
    assert holding(found, probability=0.01)


def test_lattices_of_two_steps_are_two_findings_with_a_step_each():
    axes = ("gyro_x", "gyro_y", "gyro_z")
    models = {axis: AxisModel((NOISE, Resolution(step))) for axis, step in zip(axes, (0.02, 0.02, 0.05), strict=True)}
    record = prepare(ErrorModel(models).simulate(still(5000, axes), 3))
    assert [found.axes for found in record.findings] == [axes[:2], axes[2:]]
    steps = [found.parameters["step"].value for found in record.findings]
    assert steps == pytest.approx([0.02, 0.05], rel=1e-6)


@pytest.mark.parametrize("wander", [0.0, 2e-3])
def test_a_reference_is_read_where_samples_were_taken_not_where_their_rounded_stamps_are(wander):
    sampled = 2.37e-3 * np.arange(20_000)
    sampled = sampled + wander * np.sin(2 * np.pi * sampled / 50.0)
    exact = 1e-3 * np.arange(50_100)
    motion = 5 * np.sin(2 * np.pi * 1.3 * np.concatenate([sampled, exact]))
    noise = 1e-3 * stream(2, "rounded").standard_normal(len(sampled))
    measured = pd.DataFrame({"gyro_x": motion[:20_000] + noise}, index=pd.Index(sampled.round(3), name="time"))
    reference = pd.DataFrame({"gyro_x": motion[20_000:]}, index=pd.Index(exact, name="time"))
    record = prepare(measured, reference)
    assert record.findings == ()
    assert record.sequences["gyro_x"].values.std() == pytest.approx(1e-3, rel=0.05 if wander == 0 else 1.0)


def test_rows_without_a_value_are_lost_on_their_axis():
    axes = ("gyro_x", "gyro_y")
    table = device(axes=axes).simulate(still(5000, axes), 5)
    table.iloc[100:1000:50, 0] = np.nan
    record = prepare(table)
    assert names(record) == {("gyro_x", "sample_loss")}
    assert record.sequences["gyro_x"].flawed.sum() == 18
    assert not record.sequences["gyro_y"].flawed.any()
    assert np.isfinite(record.sequences["gyro_x"].values).all()


def test_repeated_reversed_and_missing_stamps_are_described():
    table = device().simulate(still(5000), 6)
    time = table.index.to_numpy().copy()
    time[100], time[2000], time[3000] = time[99], time[1000], np.nan
    record = prepare(table.set_axis(pd.Index(time, name="time")))
    assert names(record) == set()
    assert [place.view for place in record.discrepancies] == ["stamps"]
    np.testing.assert_array_equal(record.sequences["gyro_x"].values, table["gyro_x"])


def test_a_clock_that_wanders_has_no_jitter():
    table = device().simulate(still(5000), 7)
    time = table.index.to_numpy() + np.cumsum(1e-4 * stream(7, "wander").standard_normal(5000))
    record = prepare(table.set_axis(pd.Index(time, name="time")))
    assert names(record) == set()
    assert [place.view for place in record.discrepancies] == ["stamps"]
    assert len(record.sequences["gyro_x"].values) == 5000


def test_known_effects_are_no_news_but_still_taken_out():
    clipped = device(Saturation(0.24)).simulate(still(5000), 8)
    record = prepare(clipped, start=ErrorModel({"gyro_x": AxisModel((Saturation(0.24),))}))
    assert (record.findings, record.discrepancies) == ((), ())
    assert np.abs(record.sequences["gyro_x"].values).max() > 0.24


def test_findings_can_be_simulated():
    clock = (SampleLoss(0.02, 3.0), TimestampJitter(1e-3))
    record = prepared(Saturation(0.18), StuckSamples(0.02, 3.0), Resolution(0.02), clock=clock)
    assert {name for _, name in names(record)} > {"saturation", "resolution", "sample_loss", "timestamp_jitter"}
    effects = {axis: AxisModel() for axis, _ in names(record)}
    for finding in record.findings:
        for axis, effect in finding.effects.items():
            effects[axis] = effects[axis] + effect
    assert len(ErrorModel(effects).simulate(still(1000), 1)) < 1000


def test_the_error_is_what_the_reference_leaves():
    time = 0.01 * np.arange(5000)
    moving = log.from_samples({"gyro_x": np.sin(3 * time)}, 0.01)
    measured = device(clock=(SampleLoss(0.02, 3.0), TimestampJitter(1e-3))).simulate(moving, 9)
    sequence = prepare(measured, moving).sequences["gyro_x"]
    assert sequence.conditions.time[0] == 0.0
    assert sequence.values[~sequence.flawed].std() == pytest.approx(SD, rel=0.05)
    assert np.abs(sequence.conditions.ideal["gyro_x"]).max() == pytest.approx(1.0, abs=1e-3)


def test_a_log_without_time_or_axes_is_refused():
    with pytest.raises(LogError, match="a time that advances"):
        prepare(pd.DataFrame({"gyro_x": np.ones(9)}, index=np.zeros(9)))
    with pytest.raises(LogError, match="columns"):
        prepare(pd.DataFrame({"temperature": np.ones(9)}, index=np.arange(9.0)))


@pytest.mark.parametrize(("every", "step"), [(2, 0.0), (4, 0.0), (1, 0.0), (1, 1e-4), (1, 2e-3)])
def test_an_axis_that_was_interpolated_says_nothing_and_is_told(every, step):
    """Neither noise nor noise on a fine or a coarse lattice is."""
    rng, time = stream(1, "interpolated"), 0.02 * np.arange(6000)
    values = rng.standard_normal((2, 6000)) * 1e-3
    knots = np.arange(0, 6000, every)
    values[1] = np.interp(np.arange(6000), knots, values[1, : len(knots)])
    values = np.round(values / step) * step if step else values
    record = prepare(pd.DataFrame({"gyro_x": values[0], "gyro_y": values[1]}, index=pd.Index(time, name="time")))
    assert list(record.sequences) == (["gyro_x", "gyro_y"] if every == 1 else ["gyro_x"])
    for place in record.unusable:
        assert (place.view, place.axis, place.unit) == ("values", "gyro_y", "s")
        assert place.low == pytest.approx(0.02 * every, rel=0.02)


@pytest.mark.parametrize("shock", [300.0, -9999.0])
def test_a_shock_does_not_make_the_rest_of_an_axis_look_straight(shock):
    values = stream(3, "interpolated").standard_normal((2, 6000)) * 1e-3
    values[1, 3000] = shock
    log = pd.DataFrame(dict(zip(("gyro_x", "gyro_y"), values, strict=True)), index=pd.Index(0.02 * np.arange(6000)))
    assert not prepare(log.rename_axis("time")).unusable


def test_a_log_of_nothing_but_interpolated_values_is_taken_as_it_is():
    values = np.interp(np.arange(6000), np.arange(0, 6000, 3), stream(2, "interpolated").standard_normal(2000))
    log = pd.DataFrame({"gyro_x": values}, index=pd.Index(0.02 * np.arange(6000), name="time"))
    record = prepare(log)
    assert not record.unusable
    assert list(record.sequences) == ["gyro_x"]


def test_rows_of_zeros_before_the_device_is_up_are_no_samples():
    level = dict.fromkeys(log.GYRO, 0.0) | {"accel_x": 0.0, "accel_y": 0.0, "accel_z": -9.81}
    ideal = log.from_samples({axis: np.full(3000, value) for axis, value in level.items()}, 0.01)
    table = device(axes=log.AXES).simulate(ideal, 1, "zeros")
    table.iloc[:3] = 0.0
    record = prepare(table)
    assert record.begin == pytest.approx(0.03)
    assert names(record) == set()
    assert all(np.ptp(one.values) < 10 * SD for one in record.sequences.values())
