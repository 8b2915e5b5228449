"""Pages that are made from the library: everything that it has is on them, and nothing is a mark by chance."""

from pathlib import Path

import pandas as pd
import pytest

import imugap
from imugap.effects import CATALOGUE
from imugap.interchange.devices import catalogue
from imugap.interchange.export import Target
from imugap.interchange.start_models.catalogue import READERS
from imugap.site import devices, effects, formats, limits, reference, reproduce
from imugap.site.markdown import code, plain, prose, table
from imugap.workflow.run_records import RunRecord

ROOT = Path(__file__).parents[2]


def test_a_text_is_shown_as_it_is():
    assert plain("S_B |f|\n *x*") == r"S\_B \|f\| \*x\*"
    assert code("|f|") == r"`\|f\|`"
    assert prose("A :class:`imugap.log` of ``a_b`` and c_d") == r"A `imugap.log` of `a_b` and c\_d"
    assert table(("a", "b"), [("1", "2")]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def test_every_effect_is_in_the_catalogue_with_its_parameters_and_its_picture():
    page = effects.page("pictures")
    for name, effect in effects.examples().items():
        section = page.split(f"\n## {name}\n")[1].split("\n## ")[0]
        assert all(f"`{one}`" in section for one in effect.parameters())
        assert (f"(pictures/{name}.png)" in section) == (name in effects.drawn())
    assert set(effects.examples()) == set(CATALOGUE)


def test_every_device_is_shown_with_its_licence_and_what_is_not_known():
    page = devices.page()
    for name in catalogue.names():
        section, content = page.split(f"## {plain(name)}\n")[1].split("\n## ")[0], catalogue.read(name).content
        assert plain(content["data"]["licence"]) in section
        assert all(plain(one) in section for one in content["not_known"])
        assert section.count("\n| ") == len(content["parameters"]) + 2


def test_every_reader_and_target_is_named():
    assert len(formats.logs().splitlines()) >= 7
    assert "RTKLIB" in formats.fixes()
    assert all(plain(one.tool) in formats.start_models() for one in READERS)
    assert all(f"`{one}`" in formats.targets() for one in Target)
    assert "Kalibr" in formats.conventions()


def test_the_limits_are_those_of_the_recorded_run():
    cases, found = (pd.read_csv(ROOT / f"data/blind_recorded/{name}.csv") for name in ("cases", "effects"))
    page = limits.page(cases, found)
    single = found[(found["kind"] == "single") & (found["size"] == 30)]
    assert f"{int(single['top1'].sum())} of {len(single)} |" in page.split("| all |")[1].splitlines()[0]


def test_every_public_name_is_in_the_reference():
    page = reference.page()
    assert all(f":: {name}\n" in page for name in imugap.__all__ if name != "__version__")


@pytest.mark.parametrize(("end", "time"), [(40.0, "40 s"), (400.0, "7 min")])
def test_a_figure_has_the_time_of_all_jobs_before_it(end, time):
    records = {
        "a.svg": RunRecord("draw", ("a.csv",), (), end - 10, end),
        "a.csv": RunRecord("count", ("raw.csv",), (), 0.0, end - 10),
    }
    outputs = [reproduce.RuleOutput("a.svg", "draw", "Draw a."), reproduce.RuleOutput("b.svg", "other", "Draw b.")]
    page = reproduce.page(outputs, records)
    assert f"| `a` | Draw a. | `snakemake --cores all a.svg` | {time} |" in page
    assert "`snakemake --cores all b.svg` | – |" in page
