"""The check gives a verdict in words first: one line for a sound log, else the findings with their consequences."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap import cli
from imugap.analysis.check import COMMANDS, check
from imugap.io.recording import Recording
from imugap.log import AXES, TIME
from imugap.stream import stream


def at_rest(count=30000, rate=100.0, densities=(2e-4, 2e-3)):
    values = stream(9, "check").standard_normal((count, 6)) * np.repeat(densities, 3) * np.sqrt(rate)
    values[:, 5] -= 9.80665
    return pd.DataFrame(values, columns=list(AXES), index=pd.Index(np.arange(count) / rate, name=TIME))


def checked(table):
    return check(Recording(Path("run.csv"), table))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("check")
    log = at_rest(3000)
    log.to_csv(folder / "sound.csv")
    log.assign(gyro_z=0.0).to_csv(folder / "dead.csv")
    pd.concat([log, -log]).to_csv(folder / "restart.csv")
    return folder


def test_a_sound_log_gets_one_sentence(here, capsys):
    assert cli.main(["check", "sound.csv"]) == 0
    out, err = capsys.readouterr()
    said = "usable for indices, estimate, discover: at rest, 30 s at 100 Hz, gravity along +z, too short for"
    gives = "gives white noise to 2.5 %, slow processes to 10 % up to 0.16 s and 50 % up to 3.9 s of correlation time"
    assert " ".join(out.split()) == f"sound.csv: {said} B, K (600 s), {gives}"
    assert err == ""


def test_scattered_stamps_are_harmless_at_rest(here, capsys):
    log = at_rest(3000)
    log.index = pd.Index(log.index + stream(1, "scatter").normal(0, 2e-4, 3000), name=log.index.name)
    log.to_csv("scattered.csv")
    assert cli.main(["check", "scattered.csv"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "stamps scatter by 0.2 ms, 2 % of an interval: harmless at rest" in out


def test_findings_come_with_their_consequences_in_a_table_that_fits(here, capsys):
    assert cli.main(["check", "dead.csv"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("dead.csv: usable for indices, estimate, discover with axes without use: at rest")
    row = next(line for line in lines if line.startswith("gyro_z: 0 throughout"))
    assert row.split()[-8:] == ["left", "out", "left", "out", "left", "out", "no", "no"]
    assert max(map(len, lines)) <= 100


def test_a_log_of_two_runs_is_not_usable_and_the_others_are_checked(here, capsys):
    assert cli.main(["check", "restart.csv", "sound.csv"]) == 1
    out, err = capsys.readouterr()
    assert out.splitlines()[0] == "restart.csv: not usable"
    assert out.splitlines()[1].startswith("sound.csv: usable")
    assert "restart.csv: line 3002, column time: " in err
    assert err.count("\n") == 1


def test_all_facts_are_one_json(here, capsys):
    assert cli.main(["check", "dead.csv", "sound.csv", "--json"]) == 0
    first, second = json.loads(capsys.readouterr().out)
    assert first["findings"][0]["drive"] == "no"
    assert second["findings"] == []
    assert second["timing"]["samples"] == 3000
    assert {axis["axis"] for axis in second["axes"]} == set(AXES)


@pytest.mark.parametrize("rate", [10.0, 52.0, 100.0, 400.0])
@pytest.mark.parametrize("densities", [(3e-6, 5e-4), (2e-4, 2e-3), (1e-3, 1e-2)])
@pytest.mark.parametrize("step", [0.0, 1.0])
def test_a_sound_log_of_any_device_is_without_a_finding(rate, densities, step):
    log = at_rest(12000, rate, densities)
    if step:
        lattice = np.repeat(densities, 3) * np.sqrt(rate) * step
        log = np.round(log / lattice) * lattice
    found = checked(log)
    assert [one.text for one in found.findings] == []
    assert found.verdict.startswith("usable for indices, estimate, discover: at rest")


def test_a_row_without_power_is_lost_and_no_shock():
    table = at_rest()
    table.iloc[0] = 0.0
    assert {one.name for one in checked(table).findings} == {"lost values"}


@pytest.mark.parametrize(("axes", "said"), [(AXES, "left out"), (AXES[:1], "an effect")])
def test_discovery_leaves_out_shocks_of_several_axes_alone(axes, said):
    table = at_rest()
    table.loc[table.index[9000:9004], list(axes)] += 100 * table[list(axes)].std()
    (fault,) = checked(table).findings
    assert (fault.name, fault.consequences[COMMANDS.index("discover")]) == ("shocks", said)


def test_a_log_that_is_shaken_for_15_s_is_not_called_static():
    log = at_rest()
    time = log.index.to_numpy()
    part = (time >= 100) & (time < 115)
    log[part] += np.sin(2 * np.pi * 1.5 * time[part, None] + np.arange(6))
    found = checked(log)
    assert found.never == ("indices", "estimate", "discover")
    assert "moved from 100 to 115 s" in found.findings[0].text
    assert found.verdict.endswith("next: cut the log to its rest from 115 to 300 s")


@pytest.mark.parametrize("gap", [0.05, 0.3, 2.0])
def test_gaps_stop_the_commands_that_fill_them(gap):
    log = at_rest()
    found = checked(log[(log.index < 100) | (log.index >= 100 + gap)])
    consequences = dict(zip(COMMANDS, found.findings[0].consequences, strict=True))
    assert consequences["estimate"] == "wider"
    assert consequences["walk"] == ("filled" if gap <= 0.1 else "no")
    assert consequences["drive"] == ("filled" if gap <= 0.5 else "no")


@pytest.mark.parametrize(
    ("count", "rate", "never"),
    [(4, 100.0, ("indices", "estimate", "discover")), (6000, 3000.0, ("indices",)), (3000, 100.0, ())],
)
def test_a_log_that_is_too_short_for_a_command_is_not_usable_for_it(count, rate, never):
    found = checked(at_rest(count, rate))
    assert found.never == never
    assert ("record at least 10 s" in found.verdict) == bool(never)


def test_gravity_that_the_driver_removed_is_said():
    log = at_rest()
    log["accel_z"] += 9.80665
    (found,) = checked(log).findings
    assert "without gravity" in found.text
    assert dict(zip(COMMANDS, found.consequences, strict=True))["drive"] == "no"
