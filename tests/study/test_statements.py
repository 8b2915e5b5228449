import json
from pathlib import Path

import pytest

from imugap.study import statements

STYLE = Path(__file__).parents[2] / "paper" / "style.typ"
TEXT = """
#import "style.typ": *
#statement[Of #of("counts", 0) logs, #of("share") % are good (95 % interval #of("ends")).]
#set heading(numbering: "1")
= Result <sec-result>
#statement[The ADIS16405 is #of("verdict"), _better_ by JJF 1535-2015; the 95th percentile is
  #claim("tables/ends", (model: "white"), "end [m]") (@tab-ends).]
#figure(kind: table, caption: [Ends.], table([1])) <tab-ends>
"""
NUMBERS = {"counts": [12, 3], "share": "25", "ends": ["9", "53"], "verdict": "worse"}
ENDS = {"columns": ["model", "end [m]"], "rows": [["bias", "1.0"], ["white", "2.7"]]}
STUDY = {"devices": ["bench"], "omitted": [], "config": {"chapters": []}}


@pytest.fixture
def collect(tmp_path):
    """List the statements of a text that takes its values from a table and from a file of numbers."""
    for name, content in (("numbers/a", NUMBERS), ("tables/ends", ENDS), ("numbers/study", STUDY)):
        path = tmp_path / f"{name}.json"
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps(content))
    (tmp_path / "style.typ").write_text(STYLE.read_text() + '#let of = claims-of("numbers/a")\n')

    def collected(text):
        (tmp_path / "main.typ").write_text(text)
        return statements.collect(tmp_path / "main.typ")

    return collected


def test_each_value_is_listed_with_its_cell_and_what_is_cited_beside_it(collect):
    found, faults = collect(TEXT)
    assert not faults
    assert found[["section", "file", "cell", "value", "cited"]].to_numpy().tolist() == [
        [statements.ABSTRACT, "numbers/a", "counts / 0", "12", ""],
        [statements.ABSTRACT, "numbers/a", "share", "25", ""],
        [statements.ABSTRACT, "numbers/a", "ends", "9, 53", ""],
        ["Result", "numbers/a", "verdict", "worse", "tab-ends"],
        ["Result", "tables/ends", "white / end [m]", "2.7", "tab-ends"],
    ]


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('#of("share") %', "25 %", "typed in a statement: '25'"),
        ('is #of("verdict")', "is worse", "typed in a statement: 'worse'"),
        ("the 95th percentile is", "the error is smaller than", "typed in a statement: 'smaller than'"),
        ("(@tab-ends)", "", "nothing is cited after worse"),
        ("#statement[The", "#[The", "Result: no statement"),
    ],
)
def test_what_is_typed_or_rests_on_nothing_is_a_fault(collect, old, new, fault):
    assert old in TEXT
    _, faults = collect(TEXT.replace(old, new))
    assert any(fault in one for one in faults)


def test_a_value_that_is_not_the_one_of_its_cell_is_a_fault(collect):
    claim = '[#metadata((file: "numbers/a", path: ("share",), value: "26", page: 1)) <claim>]'
    _, faults = collect(TEXT.replace('#of("share")', f"#context {claim}"))
    assert faults == [f"{statements.ABSTRACT}: share in numbers/a is 25, the text has 26"]
