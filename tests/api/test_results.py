"""Results: verdict, table, figure, page and folder, from files and from tables alike."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import imugap as ig
from imugap.log import AXES, TIME
from imugap.stream import stream

MODEL = {
    axis: [{"white_noise": {"density": 1e-3 if "accel" in axis else 1e-4}}, {"random_walk": {"density_k": 1e-4}}]
    for axis in AXES
}


@pytest.fixture(scope="module")
def log():
    return ig.simulate(MODEL, duration=200, rate=20, seed=3)


@pytest.fixture(scope="module")
def fit(log):
    return ig.estimate(log, axes=["gyro_x"], terms=["white_noise", "random_walk"])


def test_the_same_seed_gives_the_same_log_and_another_another():
    one, same, other = (ig.simulate(MODEL, 5, 20, seed=seed).table for seed in (1, 1, 2))
    pd.testing.assert_frame_equal(one, same)
    assert not one.equals(other)


def test_a_file_and_its_table_are_the_same_log(tmp_path, log):
    log.write(tmp_path / "log.csv")
    table = pd.read_csv(tmp_path / "log.csv").set_index(TIME)
    pd.testing.assert_frame_equal(ig.read(tmp_path / "log.csv").table, ig.read(table).table)
    pd.testing.assert_frame_equal(ig.read(table.reset_index()).table, log.table, rtol=1e-12)
    assert log.rate_hz == pytest.approx(20)
    assert log.duration_s == pytest.approx(200)


def test_a_table_in_other_units_is_recognised_or_refused():
    rng = stream(1, "units")
    values = rng.normal([0, 0, 0, 0, 0, 1], 0.01, (3000, 6))
    table = pd.DataFrame(values, columns=list(AXES), index=pd.Index(np.arange(3000) / 100, name=TIME))
    found = ig.read(table, units={"gyro": "deg/s", "accel": "g"})
    assert np.linalg.norm(found.table[list(AXES[3:])].mean()) == pytest.approx(9.80665, rel=1e-3)
    with pytest.raises(ig.LogError, match="column gyro_x: expected numbers"):
        ig.read(table.assign(gyro_x="a"))


def test_the_axes_of_the_file_are_at_hand():
    table = pd.DataFrame(
        stream(2, "up").normal([0, 0, 0, 0, 0, 9.80665], 0.01, (3000, 6)),
        columns=list(AXES), index=pd.Index(np.arange(3000) / 100, name=TIME),
    )  # fmt: skip
    turned = ig.read(table)
    if turned.table["accel_z"].mean() < 0:
        assert turned.in_own_axes().table["accel_z"].mean() == pytest.approx(9.80665, rel=1e-3)
    assert ig.read(table, frame="as-is").in_own_axes().table["accel_z"].mean() > 0


def test_a_check_says_for_what_a_log_is_usable(log):
    found = ig.check(log)
    assert found.usable
    assert str(found) == found.verdict
    assert "usable" in repr(found)
    dead = ig.check(ig.read(log.table.assign(gyro_z=0.0)))
    assert "axes without use" in dead.verdict
    assert [one["verdict"] in dead.verdict for one in dead.facts()] == [True]


def test_an_estimate_exports_what_its_model_has(tmp_path, fit):
    assert fit.fits
    white = fit.table.set_index("effect").loc["white_noise", "value"]
    assert white == pytest.approx(1e-4, rel=0.1)
    text = fit.export("imugap", tmp_path / "own.yaml")
    assert (tmp_path / "own.yaml").read_text() == text
    with pytest.raises(ValueError, match="did you mean kalibr"):
        fit.export("kaliber")
    assert "gyroscope_noise_density" in ig.export(ig.ErrorModel.from_mapping(MODEL), "kalibr", 20)


def test_an_export_warns_of_what_it_leaves_out_and_writes_notes_that_the_file_cannot_hold(tmp_path):
    line = {axis: [*effects, {"sinusoid": {"frequency": 5.0, "amplitude": 0.01}}] for axis, effects in MODEL.items()}
    with pytest.warns(
        UserWarning, match=r"left out: gyro_x sinusoid .*: without it the Allan deviation is 0\.\d+ times"
    ):
        text = ig.export(line, "matlab", 20, tmp_path / "imu.json")
    assert (tmp_path / "imu.json").read_text() == text
    assert "Left out: gyro_x sinusoid" in (tmp_path / "imu.json.notes.txt").read_text()


def test_a_result_draws_itself_and_shows_itself_in_a_notebook(fit, log):
    for one in (fit, ig.check(log)):
        assert isinstance(one.plot(), Figure)
        assert one.plot()._repr_png_().startswith(b"\x89PNG")
        shown = one._repr_html_()
        assert shown.lstrip().startswith("<style>")
        assert "<html" not in shown
    assert "Is the recording sound?" in log._repr_html_()


def test_two_reports_have_the_same_bytes_and_say_where_they_come_from(tmp_path, fit):
    page = fit.report(tmp_path / "one")
    fit.report(tmp_path / "two")
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()
    text = page.read_text()
    assert fit.inputs[0].sha256 in text
    assert "imugap.estimate(" in text
    assert {path.name for path in page.parent.iterdir()} == {*fit.files(), "report.html", "inputs.json"}


def test_indices_say_what_is_a_reading_and_what_a_bound(tmp_path, log):
    found = ig.indices(log, ig.simulate(MODEL, duration=200, rate=20, seed=4))
    table = found.table.set_index(["axis", "symbol"])
    white = table.loc[("gyro_x", "N")]
    assert white["low"] < 1e-4 < white["high"]
    assert table.loc[("gyro_x", "repeatability"), "runs"] == 2
    assert "from 2 runs" in found.verdict
    page = found.report(tmp_path / "found").read_text()
    assert {path.name for path in (tmp_path / "found").iterdir()} == {*found.files(), "report.html", "inputs.json"}
    assert "imugap.indices(" in page
    with pytest.raises(ValueError, match="expected at least one log"):
        ig.indices()


def test_a_report_stays_beside_files_of_others(tmp_path, fit):
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "mine.txt").write_text("kept")
    fit.report(tmp_path / "own")
    assert (tmp_path / "own" / "mine.txt").read_text() == "kept"


def test_the_command_line_and_the_function_find_the_same(tmp_path, monkeypatch, capsys, log):
    from imugap import cli

    monkeypatch.chdir(tmp_path)
    log.write("log.csv")
    assert cli.main(["estimate", "log.csv", "--axis", "gyro_y", "--terms", "white_noise", "--out", "found"]) == 0
    fit = ig.estimate("log.csv", axes=["gyro_y"], terms=["white_noise"])
    assert capsys.readouterr().out.startswith(fit.verdict)
    pd.testing.assert_frame_equal(pd.read_csv("found/estimates.csv"), fit.table, rtol=1e-14)
    page = Path("found/report.html").read_text()
    assert "imugap estimate log.csv --axis gyro_y --terms white_noise --out found" in page
    assert not re.search(r"(src|href)=.https?:", page)
