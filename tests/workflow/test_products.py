import json
from types import SimpleNamespace

import pandas as pd
import pytest

from imugap.figures import style
from imugap.workflow.job_log import job
from imugap.workflow.products import save

DATA = pd.DataFrame({"x": [1.5, 2.5]}, index=[7, 7])


def test_each_product_is_written_to_the_output_of_its_name(tmp_path):
    output = {name: str(tmp_path / f"{name}.{suffix}") for name, suffix in
              {"scores": "csv", "errors": "parquet", "numbers": "json", "figure": "svg"}.items()}  # fmt: skip
    output["table"] = [str(tmp_path / f"table_0.5s.{suffix}") for suffix in ("csv", "json", "tex")]
    save(output, scores=DATA, errors=DATA, numbers={"share": 0.5}, figure=style.text_figure("nothing"),
         table=(DATA, DATA.astype(str)))  # fmt: skip
    assert (tmp_path / "scores.csv").read_text() == "x\n1.5\n2.5\n"
    pd.testing.assert_frame_equal(pd.read_parquet(output["errors"]), DATA.reset_index(drop=True))
    assert json.loads((tmp_path / "numbers.json").read_text()) == {"share": 0.5}
    assert "<svg" in (tmp_path / "figure.svg").read_text()
    assert json.loads((tmp_path / "table_0.5s.json").read_text()) == {"columns": ["x"], "rows": [["1.5"], ["2.5"]]}
    assert all((tmp_path / f"table_0.5s.{suffix}").is_file() for suffix in ("csv", "tex"))


def test_the_same_figure_has_the_same_bytes(tmp_path):
    for name in "ab":
        save({name: str(tmp_path / name)}, **{name: style.text_figure("nothing")})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_product_without_an_output_is_refused(tmp_path):
    with pytest.raises(KeyError, match="scores"):
        save({}, scores=DATA)


def test_a_job_gives_what_its_script_works_with_and_writes_the_log(tmp_path):
    rule = SimpleNamespace(log=[tmp_path / "job.log"], input=["a"], params=["b"], output=["c"])
    with job(rule) as parts:
        print("working")
    assert parts == (["a"], ["b"], ["c"])
    assert (tmp_path / "job.log").read_text() == "working\ndone\n"
