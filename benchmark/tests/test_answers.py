import json
from copy import deepcopy

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imu_benchmark import answers
from imu_benchmark.schema import CHECKS, FormatError, check, load, read_json

EMPTY = {"schema": "imugap/discovery/1", "effects": [], "unexplained": []}
FULL = EMPTY | {
    "log": [{"path": "a.csv"}],
    "gaps": [{"view": "spectrum", "axis": "gyro_x", "low": 1.0, "high": 2.0, "unit": "Hz", "p_value": 1e-3}],
    "effects": [
        {
            "name": "sinusoid", "axes": ["gyro_x"],
            "parameters": {"amplitude": {"value": 2.0, "low": 1.0, "high": 3.0, "unit": "rad/s"}, "q": {"value": None}},
            "p_value": 1e-4, "log_score_gain": 9.0, "alternatives": [{"name": "chirp", "log_score_gain": 8.0}],
            "probabilities": {"sinusoid": 0.9, "chirp": 0.1},
        }
    ],
    "unexplained": [{"view": "mean", "axis": None, "probabilities": {"unknown": 1.0}}],
    "withheld": [{"axis": "gyro_y", "name": "chirp", "reason": "", "probabilities": {"chirp": 0.5, "other": 0.5}}],
    "distance": {"before": {"value": 9.0, "low": None, "high": 10.0}, "after": None},
    "navigation_distance": None,
    "probabilities": {"none": 0.25, "sinusoid": 0.75},
}  # fmt: skip
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=8,
)


def test_the_least_and_the_fullest_report_are_read_and_keep_what_they_say():
    assert answers.parse(EMPTY, "a") == EMPTY | {"gaps": []}
    assert answers.parse(deepcopy(FULL), "a") == FULL


@given(JSON)
def test_any_json_that_is_no_report_is_refused_in_one_line(value):
    with pytest.raises(FormatError, match=r"\Areport\.json: [^\n]*expected [^\n]*; found [^\n]*\Z"):
        answers.parse(value, "report.json")


def places(value, place=()):
    """All places of plain data."""
    yield place
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, part in parts:
        yield from places(part, (*place, name))


def replaced(value, place, new):
    if not place:
        return new
    copy = deepcopy(value)
    part = copy
    for name in place[:-1]:
        part = part[name]
    part[place[-1]] = new
    return copy


def removed(value, place):
    copy = deepcopy(value)
    part = copy
    for name in place[:-1]:
        part = part[name]
    del part[place[-1]]
    return copy


VALIDATOR = jsonschema.Draft202012Validator(load("answer"))


def agrees(value):
    try:
        check(value, load("answer"), "a")
    except FormatError:
        return not VALIDATOR.is_valid(value)
    return VALIDATOR.is_valid(value)


@given(st.sampled_from(sorted(places(FULL), key=str)), JSON)
def test_the_parser_and_the_schema_agree_on_a_report_with_anything_anywhere(place, new):
    assert agrees(replaced(FULL, place, new))


@pytest.mark.parametrize("place", [place for place in places(FULL) if place], ids=str)
def test_the_parser_and_the_schema_agree_on_a_report_without_any_part(place):
    assert agrees(removed(FULL, place))


@pytest.mark.parametrize("name", ["answer", "key", "keys", "manifest", "recipe"])
def test_schemas_are_valid_and_described_and_use_known_keywords(name):
    schema = load(name)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["title"]


def test_a_keyword_that_is_not_checked_is_an_error_and_not_passed_over():
    assert "pattern" not in CHECKS
    with pytest.raises(KeyError, match="pattern"):
        check("x", {"type": "string", "pattern": "y"}, "a")


def with_effect(**changes):
    return FULL | {"effects": [FULL["effects"][0] | changes]}


@pytest.mark.parametrize(
    ("report", "message"),
    [
        ([], "a.json: expected a value of type object; found a list of 0"),
        (
            EMPTY | {"schema": "other/1"},
            r"\.schema: expected one of imugap/discovery/1, imugap/discovery/2; found 'other/1'",
        ),
        ({"schema": "imugap/discovery/1", "effects": []}, "expected the key unexplained"),
        (with_effect(name=""), r"\.effects\[0\]\.name: expected 1 or more characters"),
        (with_effect(axes=[]), r"\.effects\[0\]\.axes: expected 1 or more items; found a list of 0"),
        (with_effect(axes="gyro_x"), r"\.effects\[0\]\.axes: expected a value of type array; found 'gyro_x'"),
        (with_effect(parameters={"q": 1.0}), r"\.parameters\.q: expected a value of type object; found 1\.0"),
        (with_effect(parameters={"q": {"value": True}}), r"q\.value: expected a value of type number or null"),
        (
            with_effect(probabilities={"a": 0.5}),
            r"probabilities: expected probabilities that add up to one; found 0\.5",
        ),
        (with_effect(probabilities={"a": 1.5}), r"probabilities\.a: expected 1 or less; found 1\.5"),
        (with_effect(probabilities={}), r"probabilities: expected 1 or more keys"),
    ],
)
def test_a_report_that_is_none_is_refused_with_place_expected_and_found(report, message):
    with pytest.raises(FormatError, match=message) as refused:
        answers.parse(report, "a.json")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "data", [b"", b"{", b"\xff\xfe", b'{"a": NaN}', b'{"a": 1e999}', b"[" * 100_000, b"1" * 10_000, b'{"a": -Infinity}']
)
def test_a_file_that_is_no_json_of_finite_numbers_is_refused_in_one_line(data, tmp_path):
    path = tmp_path / "report.json"
    path.write_bytes(data)
    with pytest.raises(FormatError, match=r"report\.json: expected JSON with finite numbers; found ") as refused:
        read_json(path)
    assert "\n" not in str(refused.value)


def test_a_huge_whole_number_is_refused_or_read_but_never_breaks(tmp_path):
    path = tmp_path / "report.json"
    path.write_text(json.dumps(with_effect(probabilities={"a": 10**400})))
    with pytest.raises(FormatError, match="expected 1 or less"):
        answers.read_report(path)


def test_an_entry_has_an_answer_to_every_case_and_to_no_other(write_entry, tmp_path):
    entry = write_entry(tmp_path / "mine", {"c1": EMPTY, "c2": FULL})
    (entry / "c1/seconds.json").write_text('{"seconds": 1.5}')
    read = answers.read_entry(entry, ["c1", "c2"])
    assert (read.name, list(read.reports), read.seconds["c1"]) == ("mine", ["c1", "c2"], 1.5)
    assert read.seconds["c2"] != read.seconds["c2"]
    with pytest.raises(FormatError, match=r"c3.*expected a file; found none"):
        answers.read_entry(entry, ["c1", "c2", "c3"])
    with pytest.raises(FormatError, match="c2: expected one of 1 cases"):
        answers.read_entry(entry, ["c1"])
    with pytest.raises(FormatError, match="expected a folder"):
        answers.read_entry(tmp_path / "none", ["c1"])
    (entry / "c1/seconds.json").write_text('{"seconds": -1}')
    with pytest.raises(FormatError, match=r"seconds: expected 0 or more; found -1"):
        answers.read_entry(entry, ["c1", "c2"])


def test_the_digest_of_an_entry_changes_with_any_answer_and_with_nothing_else(write_entry, tmp_path):
    one = answers.digest(write_entry(tmp_path / "a", {"c1": EMPTY, "c2": FULL}))
    assert answers.digest(write_entry(tmp_path / "b", {"c2": FULL, "c1": EMPTY})) == one
    assert answers.digest(write_entry(tmp_path / "c", {"c1": FULL, "c2": FULL})) != one
    (tmp_path / "a/c1/seconds.json").write_text("{}")
    assert answers.digest(tmp_path / "a") == one
    with pytest.raises(FormatError, match="expected answers"):
        answers.digest(tmp_path)
