"""Validation of configurations against closed schemas: defaults are filled in, errors suggest the nearest key."""

import re
from collections.abc import Iterator
from copy import deepcopy
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path

import yaml

from imugap.io.json_schema import Draft202012Validator, ValidationError, validators

SCALAR = re.compile(r"true|false|null|[-+]?[0-9]+([.][0-9]*)?", re.IGNORECASE)
"""Text that YAML does not read as text."""


class ConfigurationError(ValueError):
    """A configuration that does not fit its schema; the message has one line per fault."""


def configure(values: dict, schema: str | Path) -> dict:
    """Return ``values`` completed with the defaults of ``schema`` (a YAML file); faults are a ConfigurationError.

    Numbers inside nested values of the command line come as text (``--config 'navigation={trials: 20}'``); they are
    converted.
    """
    completed = _numbers(values)
    faults = [_explain(error) for error in _validator(Path(schema).read_text()).iter_errors(completed)]
    if faults:
        raise ConfigurationError("\n".join(["the configuration does not fit:", *faults]))
    return completed


def _numbers(value):
    """Return a copy of nested values in which text that is a number, true, false or null is that."""
    if isinstance(value, dict):
        return {key: _numbers(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_numbers(item) for item in value]
    return yaml.safe_load(value) if isinstance(value, str) and SCALAR.fullmatch(value) else value


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


def _explain(error: ValidationError) -> str:
    place = ".".join(map(str, error.absolute_path))
    if error.validator != "additionalProperties":
        return f"  {place}: {error.message}"
    known = list(error.schema.get("properties", {}))
    return "\n".join(
        _unknown(".".join(filter(None, [place, str(key)])), key, known) for key in error.instance if key not in known
    )


def _unknown(path: str, key: str, known: list[str]) -> str:
    near = get_close_matches(str(key).lower(), known, 1)
    hint = f"did you mean {near[0]!r}?" if near else f"known keys: {', '.join(known)}"
    return f"  {path}: no such key; {hint}"
