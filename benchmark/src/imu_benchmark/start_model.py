"""Start model of a case: what the device is known to have, for each axis a list of effects with their parameters.

It is written as YAML, of which this module reads what it writes.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from imu_benchmark.schema import FormatError

StartModel = Mapping[str, Sequence[Mapping[str, Mapping[str, float]]]]


def text(model: StartModel) -> str:
    """Return a start model as YAML."""
    lines = []
    for axis, effects in model.items():
        lines.append(f"{axis}:")
        for name, parameters in (item for effect in effects for item in effect.items()):
            lines.append(f"- {name}:")
            lines += [f"    {key}: {_number(value)}" for key, value in parameters.items()]
    return "\n".join(lines) + "\n"


def read(path: str | Path) -> dict[str, list[dict[str, dict[str, float]]]]:
    """Read a start model that :func:`text` made."""
    model: dict[str, list[dict[str, dict[str, float]]]] = {}
    effects: list[dict[str, dict[str, float]]] = []
    parameters: dict[str, float] = {}
    for number, line in enumerate(Path(path).read_text().splitlines(), start=1):
        name, _, value = line.strip("- ").partition(":")
        try:
            if line.startswith("    "):
                parameters[name] = float(value)
            elif line.startswith("- "):
                parameters = {}
                effects.append({name: parameters})
            else:
                effects = model.setdefault(name, [])
        except ValueError:
            raise FormatError(path, f"line {number}", "a number", value.strip()) from None
    return model


def _number(value: float) -> str:
    """Return a number with all its digits; without a point, 1e-05 would be a text in YAML 1.1."""
    digits = repr(value)
    return digits if "." in digits else digits.replace("e", ".0e")
