"""Records of a run: read as Snakemake writes them, and their times."""

import json
from base64 import urlsafe_b64encode

import pytest

from imugap.workflow.run_records import METADATA, read, seconds_before


def write(folder, path, rule, inputs, begin, end):
    record = {"rule": rule, "input": inputs, "params": ["1"], "starttime": begin, "endtime": end, "incomplete": False}
    name = urlsafe_b64encode(path.encode()).decode()
    place = folder / METADATA
    if len(name) > 40:  # as on a file system with short names
        place, name = place / f"@{name[:40]}", name[40:]
    place.mkdir(parents=True, exist_ok=True)
    (place / name).write_text(json.dumps(record))


def test_the_time_of_an_output_counts_each_job_before_it_once(tmp_path):
    write(tmp_path, "results/log.csv", "make", ["data/recipe.yaml"], 100.0, 130.0)
    for name, begin in (("a", 130.0), ("b", 140.0)):
        write(tmp_path, f"results/{name}.csv", f"count_{name}", ["results/log.csv"], begin, begin + 10)
    write(tmp_path, "paper/figures/a_figure_with_a_long_name.svg", "draw", ["results/a.csv", "results/b.csv"], 150, 155)
    write(tmp_path, "broken.csv", "break", [], 160.0, None)
    records = read(tmp_path)
    assert set(records) == {
        "results/log.csv", "results/a.csv", "results/b.csv", "paper/figures/a_figure_with_a_long_name.svg",
    }  # fmt: skip
    assert seconds_before("paper/figures/a_figure_with_a_long_name.svg", records) == pytest.approx(55.0)
    assert seconds_before("broken.csv", records) is None
    assert read(tmp_path / "none") == {}
