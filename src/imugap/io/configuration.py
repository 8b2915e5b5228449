"""Validation of configurations against closed schemas: defaults are filled in, errors suggest the nearest key."""

import math
from collections.abc import Iterator, Mapping
from copy import deepcopy
from functools import lru_cache
from pathlib import Path

import yaml

from imugap import spelling
from imugap.io import strict_yaml
from imugap.io.json_schema import Draft202012Validator, ValidationError, validators
from imugap.io.strict_yaml import excerpt

KINDS = {
    "object": "a mapping", "array": "a list", "string": "text", "number": "a number", "integer": "a whole number",
    "boolean": "true or false", "null": "null",
}  # fmt: skip
"""Types of JSON Schema in words."""
LIMITS = {
    "minimum": "a number >= {}", "maximum": "a number <= {}", "exclusiveMinimum": "a number > {}",
    "exclusiveMaximum": "a number < {}", "minItems": "at least {} values", "maxItems": "at most {} values",
    "pattern": "text of the form {}", "const": "{}", "minLength": "at least {} characters",
    "minProperties": "at least {} keys", "maxProperties": "at most {} keys", "multipleOf": "a multiple of {}",
}  # fmt: skip
"""Keywords of JSON Schema in words."""
WORDS = {"true": True, "false": False, "null": None}


class ConfigurationError(ValueError):
    """A configuration that does not fit its schema; the message has one line per fault."""


def read(path: str | Path, schema: str | Path) -> dict:
    """Read a configuration (YAML) and complete it (:func:`configure`); faults name the file. An empty file is valid."""
    values = strict_yaml.read(path)
    if not isinstance(values, dict | None):
        raise ConfigurationError(f"{path}: expected keys and values; found {excerpt(values)}")
    try:
        return configure(values or {}, schema, from_text=False)
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from error


def configure(values: dict, schema: str | Path, from_text: bool = True) -> dict:
    """Return ``values`` completed with the defaults of ``schema`` (a YAML file); faults are a ConfigurationError.

    Numbers inside nested values of the command line come as text (``--config 'navigation={trials: 20}'``); they are
    converted unless ``from_text`` is false.
    """
    completed = _converted(values) if from_text else deepcopy(values)
    faults = [
        f"  {place or 'top level'}: expected {expected}; found {found}"
        for error in _validator(Path(schema).read_text()).iter_errors(completed)
        for place, expected, found in explain(error)
    ]
    if faults:
        raise ConfigurationError("\n".join(["the configuration does not fit:", *dict.fromkeys(faults)]))
    return completed


def _converted(value):
    """Return a copy of nested values in which text that is a decimal number, true, false or null is that."""
    if isinstance(value, Mapping):
        return {key: _converted(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_converted(item) for item in value]
    if not isinstance(value, str) or value.lower() in WORDS:
        return WORDS[value.lower()] if isinstance(value, str) else value
    number = strict_yaml.number_in(value)
    return value if number is None or not math.isfinite(number) else number


def _with_defaults(validator, properties: dict, instance, schema: dict) -> Iterator[ValidationError]:
    if isinstance(instance, dict):
        for key, description in properties.items():
            if "default" in description:
                instance.setdefault(key, deepcopy(description["default"]))
    yield from Draft202012Validator.VALIDATORS["properties"](validator, properties, instance, schema)


_Completing = validators.extend(Draft202012Validator, {"properties": _with_defaults})


@lru_cache(maxsize=16)
def _validator(schema: str) -> Draft202012Validator:
    """Return the validator of a schema given as YAML, which takes longer to read than a configuration to complete."""
    return _Completing(yaml.safe_load(schema))


def explain(error: ValidationError) -> list[tuple[str, str, str]]:
    """Return place, what was expected and what was found of each fault of a validator."""
    place, value, rule = ".".join(map(str, error.absolute_path)), error.instance, error.validator_value
    match error.validator:
        case "additionalProperties" | "unevaluatedProperties":
            known = list(error.schema.get("properties", {}))
            return [(place, _nearest(key, known), excerpt(key)) for key in value if key not in known]
        case "required":
            return [(place, ", ".join(name for name in rule if name not in value), "none")]
        case "type":
            expected = " or ".join(KINDS[kind] for kind in ([rule] if isinstance(rule, str) else rule))
        case "enum":
            expected = (
                f"one of {', '.join(map(excerpt, rule))}{spelling.hint(value, rule) if isinstance(value, str) else ''}"
            )
        case "uniqueItems":
            return [(place, "different values", "one of them twice")]
        case name if name in LIMITS:
            expected = LIMITS[name].format(rule)
        case _:
            expected = str(error.schema.get("description", error.validator))
    return [(place, expected, excerpt(value))]


def _nearest(key: str, known: list[str]) -> str:
    question = spelling.hint(str(key), known)
    return f"a key of the schema{question}" if question else f"a key among {', '.join(known)}"
