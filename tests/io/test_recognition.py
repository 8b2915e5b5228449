"""Units, axes and stamps of recordings by what an inertial sensor can be."""

import numpy as np
import pandas as pd
import pytest
from tests.io.devices import GYRO_N, RATE, at_rest, times, turned, write_text

from imugap.io.recognition.units import given_units
from imugap.io.recording import RecordingSettings, read, stream
from imugap.log import ACCEL, AXES, GYRO, LogError
from imugap.units import factor

CONTRACT = ["time", *AXES]
NAMELESS = ["t", "wx", "wy", "wz", "ax", "ay", "az"]
"""Names that promise no unit."""


def written(path, samples, header=CONTRACT, gyro="rad/s", accel="m/s^2"):
    units = np.repeat([factor(gyro), factor(accel)], 3)
    return write_text(path / "run.csv", header, np.column_stack([times(len(samples)), samples / units]))


@pytest.mark.parametrize("gyro", ["rad/s", "deg/s"])
@pytest.mark.parametrize("accel", ["m/s^2", "g", "mg", "ft/s^2"])
@pytest.mark.parametrize("device", [at_rest, turned])
def test_units_follow_from_physics_where_no_name_says_them(tmp_path, device, gyro, accel):
    samples = device()
    found = read(written(tmp_path, samples, NAMELESS, gyro, accel), RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-6, atol=1e-9)
    assert any(sentence.startswith(f"gyro {gyro}") for sentence in found.recognised)
    assert f"accel {accel}{'' if accel == 'm/s^2' else ' -> m/s^2'} from gravity" in found.recognised


@pytest.mark.parametrize("device", [at_rest, turned])
def test_rates_in_degrees_under_a_name_or_a_header_in_radians_are_refused(tmp_path, device):
    header = ["time (s)", *(f"gyro {a} (rad/s)" for a in "xyz"), *(f"accel {a} (m/s^2)" for a in "xyz")]
    for names in (CONTRACT, header):
        with pytest.raises(LogError, match=r"gyro=rad/s or gyro=deg/s decides.*is it in deg/s\?"):
            read(written(tmp_path, device(), names, gyro="deg/s"))
    found = read(tmp_path / "run.csv", RecordingSettings(units={"gyro": "deg/s"}, frame="as-is"))
    np.testing.assert_allclose(found.log[list(GYRO)], device()[:, :3], rtol=1e-6, atol=1e-9)


def test_rates_in_degrees_without_accelerometers_that_show_a_rest_are_said(tmp_path):
    samples = np.degrees(at_rest()[:, :3])
    path = write_text(tmp_path / "run.csv", ["time", *GYRO], np.column_stack([times(), samples]))
    (sentence,) = read(path).recognised[2:]
    assert sentence.startswith("gyro rad/s from its name, though noise at rest of")
    assert sentence.endswith("is that of deg/s")
    path = write_text(tmp_path / "run.csv", ["time", *GYRO], np.column_stack([times(), np.radians(samples)]))
    assert read(path).recognised == ()


OTHER = {
    "velocity increments": (lambda x: x / RATE, r"velocity increments \[m/s\].*accel=m/s,gyro=rad"),
    "counts": (lambda x: np.round(x / 9.80665 * 16384), "counts of a converter of 16384 counts per g"),
    "feet": (lambda x: x / 0.3048, r"gravity in ft/s\^2"),
    "half of gravity": (lambda x: x / 2, "gravity in no known unit"),
}


@pytest.mark.parametrize("kind", OTHER)
@pytest.mark.parametrize("device", [at_rest, turned])
def test_what_is_no_specific_force_is_refused_with_its_reading(tmp_path, kind, device):
    spoil, reading = OTHER[kind]
    samples = device()
    samples[:, 3:] = spoil(samples[:, 3:])
    with pytest.raises(LogError, match=reading):
        read(written(tmp_path, samples))


def test_increments_and_counts_are_converted_by_the_option(tmp_path):
    samples = at_rest(up=(0, 0, -1))
    path = written(tmp_path, samples / RATE)
    found = read(path, RecordingSettings(units=given_units(["rad", "m/s"])))
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-6, atol=1e-9)
    counts = np.hstack([np.degrees(samples[:, :3]) * 131, samples[:, 3:] / 9.80665 * 16384])
    found = read(written(tmp_path, counts), RecordingSettings(units=given_units(["gyro=deg/s/131", "accel=g/16384"])))
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    ("up", "words"),
    [((0, 0, 1), "z up (FLU) -> turned, z down"), ((1, 0, 0), "x up (URF) -> turned, z down"),
     ((0, -1, 0), "y down (FDL) -> turned, z down")],
)  # fmt: skip
def test_a_device_at_rest_is_turned_by_gravity_and_that_is_said(tmp_path, up, words):
    found = read(written(tmp_path, at_rest(up=up)))
    assert words in found.recognised
    assert found.log["accel_z"].mean() == pytest.approx(-9.80665, abs=1e-2)
    gyro, other = (np.sort(np.abs(one)) for one in (found.log[list(GYRO)].to_numpy(), at_rest(up=up)[:, :3]))
    np.testing.assert_allclose(gyro, other, rtol=1e-7)


def test_a_bias_of_z_stays_one_of_z(tmp_path):
    samples = at_rest()
    samples[:, 5] += 0.02
    log = read(written(tmp_path, samples)).log
    assert log["accel_z"].mean() == pytest.approx(-9.80665 - 0.02, abs=2e-3)
    assert log[["accel_x", "accel_y"]].mean().abs().max() < 2e-3


def test_the_contract_is_taken_without_a_word(tmp_path):
    for samples in (at_rest(up=(0, 0, -1)), at_rest(up=(0.3, 0, -0.954)), turned() * np.tile([1, -1, -1], 2)):
        found = read(written(tmp_path, samples))
        assert found.recognised == ()
        np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-8)


def test_noisy_and_shaken_devices_are_taken_without_a_word(tmp_path):
    time = times(6000)
    samples = at_rest(6000, up=(0, 0, -1))
    samples[:, 1] += 0.05 * np.sin(2 * np.pi * 27 * time)
    samples[:, 3:] += 3 * np.sin(2 * np.pi * 27 * time)[:, None]
    assert read(written(tmp_path, samples)).recognised == ()
    samples = at_rest(6000, up=(0, 0, -1))
    samples[:, :3] *= 5
    assert read(written(tmp_path, samples)).recognised == ()


def test_axes_without_gravity_stay_as_they_are(tmp_path):
    samples = at_rest(up=(0, 0.015, 0))
    found = read(written(tmp_path, samples))
    assert found.weightless
    assert not any("turned" in one for one in found.recognised)
    np.testing.assert_allclose(found.table.to_numpy(), samples, rtol=1e-8)


def test_stamps_may_be_missing_where_the_rate_is_given(tmp_path):
    samples = at_rest(up=(0, 0, -1))
    path = write_text(tmp_path / "gyro.csv", [f"gyro_{a} (deg/s)" for a in "xyz"], np.degrees(samples[:, :3]))
    with pytest.raises(
        LogError, match=r"line 1: expected stamps \(--columns time=NAME\), or the rate of the samples \(--rate HZ\)"
    ):
        read(path)
    log = read(path, RecordingSettings(rate_hz=RATE)).log
    np.testing.assert_allclose(log.index, times(len(samples)))
    np.testing.assert_allclose(log.to_numpy(), samples[:, :3], rtol=1e-8)


def test_of_several_columns_of_stamps_the_most_even_that_advances_is_taken_and_said(tmp_path):
    """In any order; of two as even that with the plainest name."""
    samples, even = at_rest(up=(0, 0, -1)), times()
    arrival = even + np.random.default_rng(1).uniform(0, 0.4 / RATE, len(even))
    clocks = {"Unfiltered ts[s]": arrival, "Even ts[s]": even, "Still ts[s]": np.zeros_like(even)}
    for order in (list(clocks), [*clocks][::-1]):
        table = np.column_stack([*(clocks[name] for name in order), samples])
        found = read(write_text(tmp_path / "run.csv", [*order, *NAMELESS[1:]], table))
        assert "stamps from column 'Even ts[s]' of 3" in found.recognised
        np.testing.assert_allclose(found.log.index, even)
        said, parts = stream(tmp_path / "run.csv", RecordingSettings())
        assert "stamps from column 'Even ts[s]' of 3" in said.recognised
        np.testing.assert_allclose(pd.concat(parts).index, even)
    table = np.column_stack([even + 1e-7, even, samples])
    found = read(write_text(tmp_path / "run.csv", ["filtered ts[s]", "ts[s]", *NAMELESS[1:]], table))
    assert "stamps from column 'ts[s]' of 2" in found.recognised


@pytest.mark.parametrize(("factor", "said"), [(1.0, False), (1.01, False), (1.1, True), (3.28, True)])
def test_a_rate_that_even_stamps_contradict_is_said(tmp_path, factor, said):
    path = written(tmp_path, at_rest(up=(0, 0, -1)), NAMELESS)
    found = read(path, RecordingSettings(rate_hz=factor * RATE))
    words = f"STAMPS NOT USED: column 't' says {RATE:.5g} Hz (leave out --rate to take it)"
    assert (words in found.recognised) == said
    np.testing.assert_allclose(np.diff(found.log.index), 1 / (factor * RATE))


def test_linear_acceleration_is_said_and_refused_where_gravity_is_needed(tmp_path):
    found = read(written(tmp_path, at_rest(up=(0, 0, 0))))
    assert found.weightless
    assert "no gravity in the specific force: it was removed" in found.recognised
    with pytest.raises(LogError, match="linear acceleration: gravity was removed"):
        found.require_gravity()


def test_units_of_an_option_are_known_or_refused():
    assert given_units(["dps", "accel=G"]) == {"gyro": "deg/s", "accel": "g"}
    for text in ("gyro=g", "furlong", "accel=deg/s"):
        with pytest.raises(ValueError, match=f"expected units such as .*; found '{text}'"):
            given_units([text])


def test_a_log_that_the_package_wrote_is_taken_as_it_is(tmp_path):
    from imugap.log import write

    log = pd.DataFrame(at_rest(), index=pd.Index(times(), name="time"), columns=list(AXES))
    write(log, tmp_path / "run.parquet")
    found = read(tmp_path / "run.parquet")
    assert found.recognised == ()
    pd.testing.assert_frame_equal(found.log, log)
    log.to_parquet(tmp_path / "own.parquet")
    assert read(tmp_path / "own.parquet").log[list(ACCEL)].mean()["accel_z"] == pytest.approx(-9.8, abs=0.05)


GYRO_COUNTS = "whole numbers, which may be counts of a converter"


@pytest.mark.parametrize("device", [at_rest, turned])
@pytest.mark.parametrize("per_deg_per_s", [16.4, 131])
def test_rates_in_whole_numbers_have_no_unit_by_physics(tmp_path, device, per_deg_per_s):
    samples = device()
    samples[:, :3] = np.round(np.degrees(samples[:, :3]) * per_deg_per_s)
    path = written(tmp_path, samples, NAMELESS)
    with pytest.raises(LogError, match=GYRO_COUNTS):
        read(path)
    found = read(path, RecordingSettings(units=given_units([f"gyro=deg/s/{per_deg_per_s}"]), frame="as-is"))
    step = np.radians(1 / per_deg_per_s)
    np.testing.assert_allclose(found.log[list(GYRO)], device()[:, :3], atol=step / 2 + 1e-9)


@pytest.mark.parametrize(
    ("per_g", "reading"),
    [(1000, None), (1024, "gravity in mg, or counts of a converter of 1024 counts per g"),
     (1200, "gravity in mg, or counts of a converter of about 1200 per g"),
     (800, "counts of a converter of about 800 per g"), (4096, "counts of a converter of 4096 counts per g")],
)  # fmt: skip
def test_forces_in_whole_numbers_are_mg_or_counts(tmp_path, per_g, reading):
    samples = at_rest()
    samples[:, 3:] = np.round(samples[:, 3:] / 9.80665 * per_g)
    path = written(tmp_path, samples, NAMELESS)
    if reading is None:
        assert "accel mg -> m/s^2 from gravity" in read(path).recognised
        return
    with pytest.raises(LogError, match=reading):
        read(path)
    log = read(path, RecordingSettings(units=given_units([f"accel=g/{per_g}"]))).log
    assert log["accel_z"].mean() == pytest.approx(-9.80665, abs=0.01)


@pytest.mark.parametrize(
    ("gyro", "accel"), [("rev/min", "cm/s^2"), ("deg/h", "mGal"), ("arcsec/s", "mm/s^2"), ("urad/s", "ft/s^2")]
)
def test_rare_units_of_a_header_are_converted(tmp_path, gyro, accel):
    header = ["t [s]", *(f"Gyro {a} [{gyro}]" for a in "XYZ"), *(f"Acc {a} [{accel}]" for a in "XYZ")]
    found = read(written(tmp_path, turned(), header, gyro, accel), RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), turned(), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    ("gyro", "accel", "message"),
    [("furlong/h", "m/s^2", "found 'furlong/h' in the header"),
     ("LSB", "m/s^2", "found 'counts' in the header: counts of a"),
     ("deg/s", "Kg/lb", "found 'Kg/lb' in the header$"),
     ("mV", "m/s^2", "found 'mV' in the header"),
     ("Hz", "m/s^2", "found 'Hz' in the header"),
     ("deg/s", "V", "found 'V' in the header"),
     ("deg/s", "foo", "found 'foo' in the header"),
     ("deg/s", "0.1 g", "found '0.1 g' in the header")],
)  # fmt: skip
def test_a_unit_of_a_header_that_is_not_known_is_refused_and_the_option_decides(tmp_path, gyro, accel, message):
    header = ["t [s]", *(f"Gyro {a} [{gyro}]" for a in "XYZ"), *(f"Acc {a} [{accel}]" for a in "XYZ")]
    path = written(tmp_path, turned(), header)
    with pytest.raises(LogError, match=message):
        read(path)
    found = read(path, RecordingSettings(units=given_units(["rad/s", "m/s^2"]), frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), turned(), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("signs", [(-1, -1, -1, 1, 1, 1), (1, 1, 1, 1, -1, 1), (-1, 1, 1, 1, 1, 1)])
def test_axes_of_the_wrong_sign_are_refused_and_taken_by_name(tmp_path, signs):
    header = ["time (s)", *(f"gyro {a} (rad/s)" for a in "xyz"), *(f"accel {a} (m/s^2)" for a in "xyz")]
    path = written(tmp_path, turned() * signs, header)
    with pytest.raises(LogError, match=r"right-hand rule.*gravity turns as with -?gyro_.* as the rates of x, y, z"):
        read(path)
    columns = [f"{name}={of}" for name, of in zip(CONTRACT, header, strict=True)]
    found = read(path, RecordingSettings(columns=tuple(columns), units={"gyro": "rad/s"}, frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), turned() * signs, rtol=1e-6, atol=1e-9)


def test_lines_of_several_sensors_below_the_header_of_one_are_refused(tmp_path):
    lines = ["# IMUA;time;Acc_X(m/s^2);Acc_Y(m/s^2);Acc_Z(m/s^2)", "# IMUB;time;Gyr_X(rad/s);Gyr_Y(rad/s);Gyr_Z(rad/s)"]
    for time, row in zip(times(), at_rest(), strict=True):
        lines += [
            ";".join([tag, *(f"{value:.6f}" for value in (time, *part))])
            for tag, part in (("IMUA", row[3:]), ("IMUB", row[:3]))
        ]
    (tmp_path / "app.txt").write_text("\n".join(lines) + "\n")
    with pytest.raises(LogError, match=r"expected lines of one sensor .*; found lines of IMUA, IMUB"):
        read(tmp_path / "app.txt")


@pytest.mark.parametrize(
    ("order", "signs", "words"),
    [([1, 0, 2], [1, 1, 1], "gyro_y, gyro_x, gyro_z"), ([0, 1, 2], [1, -1, 1], "gyro_x, -gyro_y, gyro_z")],
)
def test_one_axis_of_another_sign_or_two_exchanged_are_refused(tmp_path, order, signs, words):
    samples = turned()
    samples[:, :3] = samples[:, order] * signs
    with pytest.raises(LogError, match=f"gravity turns as with {words} as the rates of x, y, z"):
        read(written(tmp_path, samples))
    settings = RecordingSettings(columns=tuple(CONTRACT), units={"gyro": "rad/s"})
    assert len(read(tmp_path / "run.csv", settings).table) == len(samples)


@pytest.mark.parametrize(
    ("stated", "size", "words"),
    [("s", 1e3, "0.1 Hz in s or 100 Hz in ms"), ("ms", 1.0, "1e.05 Hz in ms or 100 Hz in s")],
)
def test_a_unit_of_stamps_in_the_header_with_a_rate_of_no_sensor_is_refused(tmp_path, stated, size, words):
    columns = np.column_stack([times() * size, at_rest()])
    path = write_text(tmp_path / "run.csv", [f"time ({stated})", *AXES], columns)
    with pytest.raises(LogError, match=rf"as the header has it \(--time-unit decides\); found {words}"):
        read(path)
    found = read(path, RecordingSettings(time_unit="ms" if stated == "s" else "s", units={"gyro": "rad/s"}))
    assert 1 / np.diff(found.log.index).mean() == pytest.approx(RATE)


@pytest.mark.parametrize(
    ("clock", "size", "rates"),
    [("counter (ms)", 1e3, [f"{axis}Rate" for axis in "xyz"]), ("utime", 1e6, [f"pqr[{k}]" for k in range(3)])],
)
def test_counters_of_time_and_names_of_rates_are_read(tmp_path, clock, size, rates):
    columns = np.column_stack([times() * size, at_rest()])
    path = write_text(
        tmp_path / "run.csv", [clock, *rates, *(f"{axis}Accel" for axis in "xyz")], columns, form="{:.12g}"
    )
    found = read(path, RecordingSettings(units={"gyro": "rad/s"}, frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), at_rest(), rtol=1e-9)
    assert 1 / np.diff(found.log.index).mean() == pytest.approx(RATE)


@pytest.mark.parametrize("unit", ["mdeg/s", "deg/h", "mrad/s"])
def test_rates_with_the_noise_of_no_gyroscope_in_degrees_are_refused(tmp_path, unit):
    path = written(tmp_path, at_rest(), NAMELESS, gyro=unit)
    with pytest.raises(LogError, match=r"--units gyro=.*too much for deg/s"):
        read(path)
    found = read(path, RecordingSettings(units={"gyro": unit}, frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), at_rest(), rtol=1e-6)


@pytest.mark.parametrize("dead", [GYRO, ACCEL])
def test_a_triad_that_the_driver_fills_with_zeros_costs_that_triad_alone(tmp_path, dead):
    samples = at_rest()
    samples[:, [AXES.index(name) for name in dead]] = 0
    found = read(written(tmp_path, samples, NAMELESS)).regular
    assert set(found.samples) == set(AXES) - set(dead)
    assert set(found.unusable) == set(dead)


def test_accelerations_without_gravity_and_without_a_unit_are_refused_for_that(tmp_path):
    with pytest.raises(LogError, match="of no gravity: was it removed"):
        read(written(tmp_path, at_rest(up=(0, 0, 0.02)), NAMELESS))


def test_a_line_of_units_below_the_names_may_hold_units_that_are_not_known(tmp_path):
    samples = np.column_stack([times(), at_rest()])
    path = write_text(tmp_path / "run.csv", ["s", *["mV"] * 3, *["V"] * 3], samples, before=[",".join(CONTRACT)])
    with pytest.raises(LogError, match="found 'V' in the header"):
        read(path)
    assert len(read(path, RecordingSettings(units=given_units(["rad/s", "m/s^2"]))).log) == len(samples)


def test_tenths_of_a_unit_are_counts_of_it_by_the_option(tmp_path):
    samples = at_rest(up=(0, 0, -1))
    header = ["t [s]", *(f"gyro_{a} [rad/s]" for a in "xyz"), *(f"accel_{a} [0.1 g]" for a in "xyz")]
    path = written(tmp_path, samples * np.repeat([1, 10], 3), header, accel="g")
    found = read(path, RecordingSettings(units=given_units(["accel=g/10"])))
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(("last", "unit"), [(2, "rad/s"), (2, "deg/h"), (5, "m/s^2"), (5, "mg")])
def test_each_axis_is_converted_by_its_own_unit(tmp_path, last, unit):
    units = [*["deg/s"] * 3, *["g"] * 3]
    units[last] = unit
    header = ["t [s]", *(f"{name} [{one}]" for name, one in zip(AXES, units, strict=True))]
    columns = np.column_stack([times(), turned() / np.array([factor(one) for one in units])])
    path = write_text(tmp_path / "run.csv", header, columns)
    found = read(path, RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), turned(), rtol=1e-6, atol=1e-9)
    assert f"{AXES[last]} {unit} from the header" in found.recognised
    (part,) = stream(path, RecordingSettings(frame="as-is"))[1]
    np.testing.assert_allclose(part.to_numpy(), turned(), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("unit", ["LSB", "foo", "m/s"])
def test_axes_of_which_one_has_no_unit_of_an_acceleration_are_refused_and_the_option_decides(tmp_path, unit):
    header = ["t [s]", *(f"gyro_{a} [rad/s]" for a in "xyz"), "ax [m/s^2]", "ay [m/s^2]", f"az [{unit}]"]
    path = written(tmp_path, turned(), header)
    with pytest.raises(LogError, match=r"--units accel= decides for all of them.*accel_y in m/s\^2, accel_z in "):
        read(path)
    found = read(path, RecordingSettings(units={"accel": "m/s^2"}, frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), turned(), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("header", [CONTRACT, NAMELESS])
@pytest.mark.parametrize("unit", ["m/s^2", "g"])
def test_exchanged_names_of_rates_and_forces_are_refused(tmp_path, header, unit):
    samples = at_rest()[:, [3, 4, 5, 0, 1, 2]] / np.repeat([factor(unit), 1], 3)
    path = written(tmp_path, samples, header)
    with pytest.raises(LogError, match=r"--columns names them.*norm of .*of gravity, in the rates.*exchanged names\?"):
        read(path)
    columns = tuple(f"{name}={of}" for name, of in zip(["time", *ACCEL, *GYRO], header, strict=True))
    found = read(path, RecordingSettings(columns=columns, units={"gyro": "rad/s", "accel": unit}, frame="as-is"))
    np.testing.assert_allclose(found.log[list(AXES)].to_numpy(), at_rest(), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("rate", [9.80665, np.radians(9.80665), 1.0])
def test_a_device_that_turns_by_the_number_of_gravity_has_its_own_names(tmp_path, rate):
    samples = at_rest(up=(0, 0, -1))
    samples[:, 2] += rate
    for accel in ("m/s^2", "g"):
        header = ["t [s]", *(f"gyro_{a} [deg/s]" for a in "xyz"), *(f"accel_{a} [{accel}]" for a in "xyz")]
        path = written(tmp_path, samples, header, gyro="deg/s", accel=accel)
        np.testing.assert_allclose(read(path).log.to_numpy(), samples, rtol=1e-6, atol=1e-9)


def quiet(density):
    """Samples of a device at rest whose gyroscopes have a noise of this density [rad/s/sqrt(Hz)]."""
    samples = at_rest()
    samples[:, :3] *= density / GYRO_N
    samples[:, :3] += np.array([2e-4, 3e-4, -1e-4])
    return samples


BOTH = r"--units gyro=rad/s or gyro=deg/s decides.*found "


@pytest.mark.parametrize("density", [1.2e-5, 2e-5])
def test_a_quiet_gyroscope_in_degrees_with_the_noise_of_a_loud_one_in_radians_is_refused(tmp_path, density):
    path = written(tmp_path, quiet(density), NAMELESS, "deg/s", "g")
    with pytest.raises(LogError, match=BOTH):
        read(path)
    found = read(path, RecordingSettings(units={"gyro": "deg/s"}, frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), quiet(density), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("density", [5e-5, 8e-5])
def test_a_noise_of_no_gyroscope_in_radians_is_of_one_in_degrees(tmp_path, density):
    found = read(written(tmp_path, quiet(density), NAMELESS, "deg/s", "g"), RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), quiet(density), rtol=1e-6, atol=1e-9)


def test_the_noise_of_a_mems_in_radians_is_taken_and_the_other_reading_said(tmp_path):
    found = read(written(tmp_path, quiet(3e-4), NAMELESS), RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), quiet(3e-4), rtol=1e-6, atol=1e-9)
    (sentence,) = [one for one in found.recognised if one.startswith("gyro rad/s from noise at rest")]
    assert sentence.endswith("or of a quieter gyroscope in deg/s (--units gyro=deg/s)")


@pytest.mark.parametrize(("gyro", "density"), [("rad/s", 2e-6), ("rad/s", 2e-5), ("deg/s", 2e-7)])
def test_a_noise_below_that_of_a_mems_in_radians_is_refused(tmp_path, gyro, density):
    with pytest.raises(LogError, match=BOTH + "rates that may be in rad/s or in deg/s"):
        read(written(tmp_path, quiet(density), NAMELESS, gyro))


def test_a_noise_of_no_gyroscope_in_degrees_is_of_one_in_radians(tmp_path):
    found = read(written(tmp_path, quiet(5e-7), NAMELESS), RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), quiet(5e-7), rtol=1e-6, atol=1e-9)


def test_columns_that_look_like_a_missing_triad_are_said_and_taken_by_name(tmp_path):
    samples = at_rest(up=(0, 0, -1))
    header = ["t [s]", *(f"gyro_{a} [rad/s]" for a in "xyz"), *(f"{a} force [g]" for a in ("Long", "Side", "Down"))]
    path = written(tmp_path, samples, header, accel="g")
    (sentence,) = [one for one in read(path).recognised if "lacks axes" in one]
    assert sentence.startswith("accel lacks axes, though Long force [g], Side force [g], Down force [g] may be some")
    found = read(path, RecordingSettings(columns=tuple(CONTRACT), units={"gyro": "rad/s", "accel": "g"}))
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("stated", [False, True])
def test_increments_of_angle_and_velocity_become_rates_and_forces(tmp_path, stated):
    samples = at_rest(up=(0, 0, -1))
    units = (" [rad]", " [m/s]") if stated else ("", "")
    header = ["t [s]", *(f"{name}{a}{unit}" for name, unit in zip(("dAng", "dVel"), units, strict=True) for a in "XYZ")]
    found = read(written(tmp_path, samples / RATE, header))
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-6, atol=1e-8)
