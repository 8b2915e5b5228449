"""Recorded drives: read as their publishers say, degraded as told, tuned by what the filter sees; and the real ones."""

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.io

from imugap.effects import RandomWalk, WhiteNoise
from imugap.io import gnss
from imugap.io.catalogue.public_drives import (
    CAR_LAG_S,
    CAR_MOUNTING,
    FLIGHT_BEGIN_S,
    PublicDrive,
    read_car,
    read_flight,
)
from imugap.log import ACCEL, AXES, GYRO, LogError
from imugap.model import ErrorModel
from imugap.numerics.rotation import from_euler
from imugap.stream import stream
from imugap.study.drive.recorded_drive import TUNED, StandardReceiver, aircraft, car, model_from_rest, scaled
from imugap.units import STANDARD_GRAVITY

ROOT = Path(__file__).parents[3]
SEED = 91
RECEIVER = StandardReceiver(1.0, (1.5, 1.5, 3.0), (0.1, 0.1, 0.2))


def publish_car(folder, samples, start="2025-07-08 19:34:21.500"):
    """Write samples in vehicle axes as the publisher of the car has them: turned, in g and deg/s."""
    turn = from_euler(CAR_MOUNTING)
    gyro, accel = (turn.apply(samples[list(triad)].to_numpy(copy=True)) for triad in (GYRO, ACCEL))
    counter = 261906 + 10 * np.arange(len(samples))
    rows = np.column_stack([accel / STANDARD_GRAVITY, np.degrees(gyro), counter])
    pd.DataFrame(rows).to_csv(folder / "imu.csv", header=False, index=False)
    moment = pd.Timestamp(start)
    head = struct.pack("<64xId", int(moment.timestamp()), moment.microsecond / 1e6)
    (folder / "imu.tag").write_bytes(head + bytes(80))
    word = "{} {} 40.0 -105.0 1600.0 1 20 0.01 0.01 0.01 0 0 0 0 0 1.0 2.0 3.0 0.05 0.05 0.06 0 0 0"
    lines = [word.format("2025/07/08", f"19:34:2{second}.499") for second in range(2, 6)]
    (folder / "gnss.pos").write_text("% head\n" + "\n".join(lines) + "\n")
    return folder / "imu.csv", folder / "imu.tag", folder / "gnss.pos"


@pytest.fixture
def samples():
    rng = stream(SEED, "samples")
    table = pd.DataFrame(0.1 * rng.standard_normal((500, 6)), columns=list(AXES))
    table["accel_z"] -= 9.8
    return table


def test_a_car_is_read_in_vehicle_axes_on_one_clock(tmp_path, samples, sets):
    found = read_car(*publish_car(tmp_path, samples), sets["rtklibexplorer_drive"])
    np.testing.assert_allclose(found.log.to_numpy(), samples.iloc[1:-1].to_numpy(), atol=1e-9)
    assert np.diff(found.log.index) == pytest.approx(0.01)
    assert found.fixes.index[0] == pytest.approx(22.499 - 21.5 + CAR_LAG_S, abs=1e-6)
    np.testing.assert_allclose(np.degrees(found.fixes[["latitude", "longitude"]].iloc[0]), [40, -105])
    assert found.fixes[["vel_n", "vel_e", "vel_d"]].iloc[0].tolist() == [1, 2, -3]
    assert found.fixes[["sd_vel_n", "sd_vel_d"]].iloc[0].tolist() == [0.05, 0.06]


def test_a_car_with_a_column_less_or_a_cut_tag_is_refused(tmp_path, samples, sets):
    log, tag, fixes = publish_car(tmp_path, samples)
    pd.read_csv(log, header=None).iloc[:, :6].to_csv(log, header=False, index=False)
    with pytest.raises(LogError, match=r"imu\.csv: columns: expected 7; found 6"):
        read_car(log, tag, fixes, sets["rtklibexplorer_drive"])
    log, tag, fixes = publish_car(tmp_path, samples)
    tag.write_bytes(b"cut")
    with pytest.raises(LogError, match=r"imu\.tag: file: expected a head of 76 bytes; found 3 bytes"):
        read_car(log, tag, fixes, sets["rtklibexplorer_drive"])


def test_a_flight_gets_its_biases_back(tmp_path):
    count = 15_000
    time, rng = 0.02 * np.arange(count), stream(SEED, "flight")
    names = ("p", "q", "r", "ax", "ay", "az")
    data = {name: rng.standard_normal(count) for name in names} | {
        f"{name}_bias": np.full(count, 0.5) for name in names
    }
    data["az"] = np.full(count, -9.8)
    data["ax"][:3] = data["ay"][:3] = data["az"][:3] = 0
    tow = np.floor(time)
    data |= {"time": time, "GPS_TOW": tow, "satVisible": np.where(time < 5, 2, 8), "lat": 45 + 1e-6 * tow,
             "lon": np.full(count, -93.0), "alt": np.full(count, 250.0)}  # fmt: skip
    data |= {name: np.zeros(count) for name in ("vn", "ve", "vd", "navvn", "navve", "navvd", "phi", "theta", "psi")}
    scipy.io.savemat(tmp_path / "flight.mat", {"flight_data": data})
    found = read_flight(tmp_path / "flight.mat")
    assert found.log.index[0] >= FLIGHT_BEGIN_S
    assert found.fixes.index[0] >= FLIGHT_BEGIN_S
    np.testing.assert_allclose(found.log["accel_z"], -9.3)
    assert np.diff(found.fixes.index) == pytest.approx(1.0)
    scipy.io.savemat(tmp_path / "other.mat", {"other": 1})
    with pytest.raises(LogError, match="structure: expected flight_data; found other"):
        read_flight(tmp_path / "other.mat")


@pytest.fixture(scope="module")
def recorded(lap):
    """A simulated drive as a recording: the survey is at 4 Hz, to a centimetre."""
    receiver = replace(lap.receiver, rate_hz=4, position_std=(0.01,) * 3, velocity_std=(0.05,) * 3)
    fixes = replace(lap, receiver=receiver).fixes(1, SEED)
    return PublicDrive(lap.record(1, SEED), fixes, None, lap.receiver.lever_m)


def test_a_survey_is_degraded_to_what_the_receiver_is(recorded):
    found = [RECEIVER.degrade(recorded.fixes, SEED, draw) for draw in range(10)]
    ellipsoid = gnss.origin(recorded.fixes)
    true = gnss.local(recorded.fixes.loc[found[0].index], ellipsoid)
    off = np.concatenate([gnss.local(one, ellipsoid) - true for one in found])
    assert np.diff(found[0].index) == pytest.approx(1.0)
    std = np.array([*RECEIVER.position_std, *RECEIVER.velocity_std])
    assert np.abs(off.std(axis=0) / std - 1).max() < 4 / np.sqrt(2 * len(off))
    told = found[0][["sd_n", "sd_vel_n"]].iloc[0].to_numpy()
    np.testing.assert_allclose(told, np.hypot([1.5, 0.1], [0.01, 0.05]))


def test_errors_are_those_of_the_antenna(recorded, lap):
    test = car(recorded, RECEIVER)
    solution = test.navigate(recorded.fixes, lap.model)
    off = test.errors(solution).loc[60:]
    assert np.sqrt((off**2).mean()).max() < 0.03


def test_an_outage_drifts_as_predicted_where_the_model_is_right(recorded, lap):
    test = car(recorded, RECEIVER)
    found = test.outage(RECEIVER.degrade(recorded.fixes, SEED, 0), lap.model, 120.0, 40.0)
    assert found.index[-1] == pytest.approx(40, abs=0.3)
    assert found["predicted"].iloc[-1] > 5 * found["predicted"].iloc[0]
    assert (found["nees"] < 14).all()


def test_wheels_hold_an_outage_even_where_the_device_stands_for_the_axle(recorded, lap):
    """The arm of 1.3 m is told to nobody: what is predicted is less than without wheels, and not too little."""
    test, fixes = car(recorded, RECEIVER), RECEIVER.degrade(recorded.fixes, SEED, 0)
    plain, rolling = (one.outage(fixes, lap.model, 150.0, 45.0) for one in (test, test.rolling))
    assert 0.1 < rolling["predicted"].iloc[-1] / plain["predicted"].iloc[-1] < 0.8
    assert (rolling["nees"] < 14).all()


@pytest.mark.slow
def test_tuning_finds_noise_that_is_told_wrongly(recorded, lap):
    """White noise told eight times too small or too large comes back to within a factor of two."""
    test, fixes = car(recorded, RECEIVER), RECEIVER.degrade(recorded.fixes, SEED, 0)
    model = ErrorModel.from_mapping({
        axis: [{"white_noise": {"density": 1e-4 if axis in GYRO else 1e-3}},
               {"random_walk": {"density_k": 1e-6 if axis in GYRO else 1e-5}},
               {"turn_on_bias": {"std": 5e-4 if axis in GYRO else 0.02}}]
        for axis in AXES
    })  # fmt: skip
    wrong = scaled(model, {"gyro_white": 8.0, "accel_white": 8.0, "gyro_walk": 1.0, "accel_walk": 1.0})
    tuned, way = test.tune(fixes, wrong)
    assert way["likelihood"].is_monotonic_increasing
    assert list(way.columns) == [*TUNED, "likelihood"]
    told = {axis: next(effect.density for effect in tuned[axis] if isinstance(effect, WhiteNoise)) for axis in AXES}
    assert 0.5 <= told["gyro_z"] / 1e-4 <= 4
    assert way.iloc[-1]["likelihood"] >= test.log_likelihood(fixes, model, dict.fromkeys(TUNED, 1.0)) - 2


def test_factors_multiply_what_they_name():
    gyro = [{"white_noise": {"density": 1.0}}, {"random_walk": {"density_k": 2.0}}]
    accel = [{"white_noise": {"density": 3.0}}, {"turn_on_bias": {"std": 5.0}}]
    model = ErrorModel.from_mapping({"gyro_x": gyro, "accel_x": accel})
    found = scaled(model, dict(zip(TUNED, (2.0, 3.0, 5.0, 7.0), strict=True)))
    assert found["gyro_x"].effects == (WhiteNoise(2.0), RandomWalk(10.0))
    assert [effect.parameters() for effect in found["accel_x"]] == [{"density": 9.0}, {"std": 5.0}]


def test_the_real_car_rests_level_and_its_speed_is_that_of_its_fixes(sets, mirror):
    dataset = sets["rtklibexplorer_drive"]
    found = read_car(*(dataset.file(1, content).place(mirror) for content in ("log", "clock", "fixes")), dataset)
    rest = found.log.loc[:32].mean()
    assert np.hypot(rest["accel_x"], rest["accel_y"]) < 0.3
    assert rest["accel_z"] == pytest.approx(-9.93, abs=0.05)
    receiver = StandardReceiver.read(ROOT / "data" / "drive.yaml", "car")
    test = car(found, receiver)
    fixes = receiver.degrade(found.fixes, SEED)
    solution = test.navigate(fixes, model_from_rest(found.log, 32.0))
    off = test.errors(solution).loc[80:]
    assert np.sqrt((off**2).mean()).max() < 1.2
    assert 0.8 < solution.record.statistic.mean() / 6 < 1.3


def test_the_real_flight_agrees_with_the_filter_aboard(sets, mirror):
    found = read_flight(sets["thor_flight75"].file(1).place(mirror))
    test = aircraft(found, StandardReceiver.read(ROOT / "data" / "drive.yaml", "flight"))
    model, _ = test.tune(found.fixes, model_from_rest(found.log, 157.0))
    solution = test.navigate(found.fixes, model)
    air = solution.trajectory.loc[300:500]
    theirs = found.aboard.loc[300:500]
    for name, limit in (("roll", 3.0), ("pitch", 2.0)):
        apart = air[name] - np.interp(air.index, theirs.index, theirs[name])
        assert np.degrees(np.sqrt(np.mean(apart**2))) < limit
