import copy
from functools import cache
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from imugap.io.configuration import ConfigurationError, configure
from imugap.io.json_schema import Draft202012Validator

WORKFLOW = Path(__file__).parents[2] / "workflow"
SCHEMA = WORKFLOW / "schemas" / "study.schema.yaml"
SCHEMAS = sorted((WORKFLOW / "schemas").glob("*.yaml"))


@cache
def read(path):
    return yaml.safe_load(path.read_text())


def overlaid(below, above):
    """What Snakemake makes of a configuration and an overlay: mappings merge, anything else is replaced."""
    merged = copy.deepcopy(below)
    for key, value in above.items():
        nested = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = overlaid(merged[key], value) if nested else value
    return merged


def properties(schema, place=""):
    """Every property at any depth, with its path."""
    for key, value in schema.get("properties", {}).items():
        yield f"{place}{key}", value
        yield from properties(value, f"{place}{key}.")
    for name, value in schema.get("$defs", {}).items():
        yield from properties(value, f"$defs.{name}.")


def parts(schemas, choose=lambda value: True):
    return [
        pytest.param(path, key, value, id=f"{path.name.split('.')[0]}:{key}")
        for path in schemas
        for key, value in properties(read(path))
        if choose(value)
    ]


@pytest.mark.parametrize(("path", "key", "value"), parts(SCHEMAS))
def test_every_property_is_described(path, key, value):
    assert len(value["description"]) > 10
    assert value["description"].endswith(".")


@pytest.mark.parametrize(("path", "key", "value"), parts(SCHEMAS, lambda value: "default" in value))
def test_every_default_fits_its_own_schema(path, key, value):
    validator = Draft202012Validator({"$defs": read(path).get("$defs", {})} | value)
    assert [error.message for error in validator.iter_errors(value["default"])] == []


@pytest.mark.parametrize(("path", "key", "value"), parts(SCHEMAS, lambda value: value.get("type") == "object"))
def test_every_mapping_is_closed(path, key, value):
    assert value["additionalProperties"] is False or "propertyNames" in value


@pytest.mark.parametrize("path", SCHEMAS, ids=lambda path: path.name)
def test_a_schema_is_a_closed_schema(path):
    schema = read(path)
    Draft202012Validator.check_schema(schema)
    closed = schema["items"] if schema["type"] == "array" else schema
    assert closed["additionalProperties"] is False or "propertyNames" in closed
    assert schema["title"]
    assert schema["description"]


@pytest.mark.parametrize(("path", "key", "value"), parts([SCHEMA]))
def test_every_choice_of_the_study_has_a_default(path, key, value):
    assert "default" in value or key.startswith("$defs.")


def test_an_empty_configuration_is_completed_at_every_depth():
    found = configure({}, SCHEMA)
    assert found["seed"] == 20230701
    assert found["navigation"]["mechanisation"] == "local"
    assert found["sites"]["adis16405"] == {"latitude_deg": 51.08, "height_m": 1100}
    assert found["mirror"] is None
    for key, value in properties(read(SCHEMA)):
        at = found
        if not key.startswith("$defs."):
            for part in key.split("."):
                at = at[part]
            assert value["default"] in (at, {})


def test_completing_twice_is_completing_once():
    assert configure(configure({}, SCHEMA), SCHEMA) == configure({}, SCHEMA)


def test_completing_neither_changes_what_is_given_nor_shares_it():
    given_values = {"bench": {"rate_hz": 200}}
    found = configure(given_values, SCHEMA)
    assert given_values == {"bench": {"rate_hz": 200}}
    assert found["bench"] == {"rate_hz": 200, "duration_s": 4000}
    found["power_cycles"].append(99)
    assert 99 not in configure({}, SCHEMA)["power_cycles"]


def test_the_study_states_nothing_but_the_defaults():
    assert configure(read(WORKFLOW / "config" / "study.yaml"), SCHEMA) == configure({}, SCHEMA)


def test_the_quick_overlay_fits_and_is_quick():
    study, quick = (read(WORKFLOW / "config" / f"{name}.yaml") for name in ("study", "quick"))
    found = configure(overlaid(study, quick), SCHEMA)
    assert found["bench"]["duration_s"] == 1000
    assert found["seed"] == study["seed"]


@pytest.mark.parametrize("name", ["study", "quick"])
def test_times_of_a_configuration_agree_with_one_another(name):
    study, other = (read(WORKFLOW / "config" / f"{one}.yaml") for one in ("study", name))
    found = configure(overlaid(study, other), SCHEMA)
    navigation = found["navigation"]
    assert navigation["table_horizon_s"] in navigation["horizons_s"]
    assert navigation["calibration_s"] + max(navigation["horizons_s"]) < found["bench"]["duration_s"]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"sede": 1}, "top level: expected a key of the schema (did you mean seed?); found 'sede'"),
        (
            {"navigation": {"trails": 5}},
            "navigation: expected a key of the schema (did you mean trials?); found 'trails'",
        ),
        (
            {"sites": {"own": {"latitude": 1, "latitude_deg": 1, "height_m": 0}}},
            "sites.own: expected a key of the schema (did you mean latitude_deg?); found 'latitude'",
        ),
        ({"bench": {"zzz": 1}}, "bench: expected a key among duration_s, rate_hz; found 'zzz'"),
        ({"seed": "one"}, "seed: expected a whole number; found 'one'"),
        ({"seed": -1}, "seed: expected a number >= 0; found -1"),
        ({"devices": {"bench": [1, 0]}}, "devices.bench.1: expected a number >= 1; found 0"),
        ({"navigation": {"mechanisation": "flat"}}, "navigation.mechanisation: expected one of 'local'"),
        (
            {"sites": {"own": {"latitude_deg": 91, "height_m": 0}}},
            "sites.own.latitude_deg: expected a number <= 90; found 91",
        ),
        ({"sites": {"own": {"height_m": 0}}}, "sites.own: expected latitude_deg; found none"),
    ],
)
def test_a_fault_names_its_place_and_what_was_meant(values, message):
    with pytest.raises(ConfigurationError) as caught:
        configure(values, SCHEMA)
    assert f"\n  {message}" in str(caught.value)


def test_every_fault_has_its_line():
    with pytest.raises(ConfigurationError) as caught:
        configure({"sede": 1, "seed": "x", "bench": {"rate": 1, "duration": 2}}, SCHEMA)
    assert len(str(caught.value).splitlines()) == 5


@given(st.recursive(st.none() | st.booleans() | st.integers() | st.text(max_size=5), lambda x: st.lists(x, max_size=3)))
def test_what_is_no_run_list_is_refused(value):
    runs = isinstance(value, list) and all(type(k) is int and 1 <= k <= 6 for k in value)
    if runs and len(set(value)) == len(value):
        assert configure({"devices": {"adis16405": value}}, SCHEMA)["devices"]["adis16405"] == value
    else:
        with pytest.raises(ConfigurationError, match=r"devices\.adis16405"):
            configure({"devices": {"adis16405": value}}, SCHEMA)


def test_a_numeric_key_is_a_fault_like_any_other():
    with pytest.raises(ConfigurationError, match=r"top level: expected a key among .*; found 1"):
        configure({1: 2}, SCHEMA)


def test_numbers_that_come_as_text_are_numbers_and_paths_stay_text():
    found = configure({"navigation": {"trials": "20", "horizons_s": ["10", "60.5"]}, "own_logs": ["run1.csv"]}, SCHEMA)
    assert found["navigation"]["trials"] == 20
    assert found["navigation"]["horizons_s"] == [10, 60.5]
    assert found["own_logs"] == ["run1.csv"]
