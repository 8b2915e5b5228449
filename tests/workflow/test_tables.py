import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.study.static import he2023
from imugap.units import FACTORS
from imugap.workflow import tables

PUBLISHED = Path(__file__).parents[2] / "data" / "published"
finite = st.floats(allow_nan=False, allow_infinity=False)
readable = st.floats(1e-4, 1e6) | st.floats(-1e6, -1e-4)


def tex(shown, tmp_path):
    tables.write(tmp_path / "t", shown, shown)
    return (tmp_path / "t.tex").read_text()


@given(st.lists(st.tuples(finite, st.integers(-(10**9), 10**9)), min_size=1, max_size=8))
def test_csv_gives_the_numbers_back_to_the_last_bit(tmp_path_factory, rows):
    data = pd.DataFrame(rows, columns=["x", "k"])
    stem = tmp_path_factory.mktemp("table") / "deep" / "numbers"
    tables.write(stem, data, data)
    head, *lines = stem.with_suffix(".csv").read_text().splitlines()
    assert head == "x,k"
    assert [(float(x), int(k)) for x, k in (line.split(",") for line in lines)] == rows


def test_json_holds_what_the_page_shows(tmp_path):
    shown = pd.DataFrame({"axis": ["x", "y"], "deg/√h": ["1.0 [0.9, 1.1]", 2]})
    tables.write(tmp_path / "t", shown, shown)
    page = json.loads((tmp_path / "t.json").read_text())
    assert page == {"columns": ["axis", "deg/√h"], "rows": [["x", "1.0 [0.9, 1.1]"], ["y", "2"]]}


def test_tex_is_a_tabular_with_a_line_per_row(tmp_path):
    lines = tex(pd.DataFrame({"a": [1, 2], "b": [3, 4], "c": [5, 6]}), tmp_path).splitlines()
    assert lines[0] == r"\begin{tabular}{lrr}"
    assert lines[2] == r"a & b & c \\"
    assert [line for line in lines if line[0].isdigit()] == [r"1 & 3 & 5 \\", r"2 & 4 & 6 \\"]
    assert lines[-1] == r"\end{tabular}"


@pytest.mark.parametrize(
    ("plain", "escaped"),
    [("5 %", r"5 \%"), ("a_b", r"a\_b"), ("a & b", r"a \& b"), ("#1", r"\#1"), ("3 µg", r"3 $\mu$g"), ("1–2", "1--2")],
)
def test_tex_escapes(plain, escaped, tmp_path):
    assert f"\n{escaped} " in tex(pd.DataFrame({"x": [plain]}), tmp_path)


@given(st.text(alphabet="ab1 %_&#√hσ≤²°τ–—µ×−", max_size=20))
def test_tex_of_known_signs_is_ascii_with_every_special_sign_escaped(text):
    cell = tables.tex(text.replace("√", "√h"))
    assert cell.isascii()
    assert not re.search(r"(?<!\\)[%&#]", cell)
    assert cell.count("$") % 2 == 0


@pytest.mark.parametrize("unit", FACTORS)
def test_every_unit_is_ascii_in_tex(unit):
    assert tables.tex(tables.unit(unit)).isascii()


def test_what_the_audit_shows_is_ascii_in_tex():
    printed = [pd.read_csv(path) for path in sorted(PUBLISHED.glob("he2023_*.csv"))]
    found = he2023.findings(*printed).astype(str)
    assert [cell for cell in found.to_numpy().ravel() if not tables.tex(cell).isascii()] == []


@pytest.mark.parametrize("sign", ["\\", "$", "{", "^", "~"])
def test_signs_that_tex_reads_are_escaped(sign):
    assert tables.tex(sign) != sign


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (1234.4, "1234"),
        (1234567.8, "1234568"),
        (999.6, "1000"),
        (9.9999e-5, "0.000100"),
        (12.345, "12.3"),
        (0.012345, "0.0123"),
        (-2.0, "-2.00"),
        (0.0, "0"),
        (1.2345e-9, "1.23e-09"),
        (float("nan"), "—"),
        (float("inf"), "—"),
    ],
)
def test_numbers_have_three_digits_and_all_before_the_point(value, shown):
    assert tables.number(value) == shown


@given(readable, st.integers(1, 6))
def test_a_number_is_off_by_half_of_its_last_digit_at_most(value, digits):
    shown = float(tables.number(value, digits))
    assert abs(shown - value) <= 0.5000001 * 10.0 ** (np.floor(np.log10(abs(value))) - digits + 1)


@pytest.mark.parametrize(
    ("value", "decimals", "shown"),
    [(1234.0, -2, "1200"), (-0.001, 2, "0.00"), (2.5, 1, "2.5"), (-0.4, 0, "0"), (0.125, 3, "0.125")],
)
def test_fixed_rounds_and_knows_no_negative_zero(value, decimals, shown):
    assert tables.fixed(value, decimals) == shown


@pytest.mark.parametrize(
    ("numbers", "shown"),
    [
        ((1.2345, 1.1345, 1.3345), "1.23 [1.13, 1.33]"),
        ((1234.0, 1000.0, 1500.0), "1230 [1000, 1500]"),
        ((0.5, -0.04, 1.04), "0.50 [-0.04, 1.04]"),
        ((10.0, 4.5, 319.0), "10 [4, 319]"),
        ((0.5, 1e-9, 1.0), "0.50 [0.00, 1.00]"),
        ((2.0, float("nan"), 3.0), "2.00"),
        ((2.0, 2.0, 2.0), "2.00"),
    ],
)
def test_an_interval_is_shown_to_two_digits_of_its_half_width(numbers, shown):
    assert tables.interval(*numbers) == shown


@given(st.floats(-1e3, 1e3), st.floats(1e-5, 1e3), st.floats(0, 1))
def test_an_interval_holds_its_value_as_shown(low, width, share):
    shown = tables.interval(low + share * width, low, low + width)
    value, below, above = (float(text) for text in re.findall(r"-?\d+\.?\d*", shown))
    assert below <= value <= above
    assert abs(below - low) < 0.06 * width
    assert abs(above - low - width) < 0.06 * width


def test_a_narrow_interval_keeps_its_digits():
    assert tables.interval(3e-9, 2e-9, 4e-9) != "0.00000000 [0.00000000, 0.00000000]"


@pytest.mark.parametrize(
    ("ends", "shown"),
    [
        ((1.5, 1.4, 1.6, "s"), "1.50 [1.40, 1.60] s"),
        ((1.5, None, 1.6, "1"), "1.50 [—]"),
        ((0.05, 0.05, 0.05, "rad/s/sqrt(Hz)"), "0.0500 rad/s/√Hz"),
    ],
)
def test_a_parameter_has_its_interval_and_its_unit(ends, shown):
    assert tables.parameter(*ends) == shown


def test_a_dot_in_the_stem_stays(tmp_path):
    data = pd.DataFrame({"x": [1]})
    tables.write(tmp_path / "index_0.5s", data, data)
    assert (tmp_path / "index_0.5s.csv").exists()


@pytest.mark.parametrize(
    ("value", "std", "shown"),
    [(-0.00054259, 0.016, ("-0.001", "0.016")), (26.9604, 0.5, ("26.96", "0.50")), (123.4, 57.0, ("123", "57")),
     (-1e-9, 0.016, ("0.000", "0.016")), (28.995, 0.0, ("28.995", "–"))],
)  # fmt: skip
def test_a_value_has_the_digits_of_its_deviation(value, std, shown):
    assert tables.measured(value, std) == shown
