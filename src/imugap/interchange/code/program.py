"""Programs of an error model: its effects as blocks, and the templates of the languages."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from hashlib import blake2b

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from imugap import __version__, log
from imugap.effects.block import CHANNELS, Block
from imugap.effects.effect import Effect, Stage
from imugap.interchange.code.translation import draws, to_cpp, to_python
from imugap.model import ErrorModel


class Language(StrEnum):
    """Language of a program, by its target of an export."""

    PYTHON = "python"
    """Module that needs NumPy alone."""
    CPP = "cpp"
    """Header of C++17 that needs the standard library alone."""
    GAZEBO_PLUGIN = "gazebo-plugin"
    """Source of a system plug-in of Gazebo, with the header in it."""


@dataclass(frozen=True)
class Placed:
    """One effect of an axis in a program.

    Attributes
    ----------
    axis, effect, block
        Axis, or the pseudo-axis of the clock; effect; its block.
    key
        Number of its random stream: a hash of axis, name of the effect and number among its like.
    """

    axis: str
    effect: Effect
    block: Block
    key: int

    @property
    def kind(self) -> str:
        """Name of its class in the program: that of the effect, and that of its step where it is not the only one."""
        step = self.block.step.__name__.strip("_")
        return type(self.effect).__name__ + (step.title() if step != "step" else "")

    @property
    def draws(self) -> bool:
        """Whether it draws random numbers."""
        return draws(self.block.step) or (self.block.start is not None and draws(self.block.start))

    @property
    def on_output(self) -> bool:
        """Whether it acts on the output, not on the error alone."""
        return self.effect.stage >= Stage.FILTER

    @property
    def values(self) -> dict[str, float | int | list[float]]:
        """Constants and initial states as plain numbers."""
        return {name: _plain(value) for name, value in self.block.values.items()}

    def describe(self) -> str:
        """Return axis, name and parameters as text."""
        return describe(self.axis, self.effect)


def describe(axis: str, effect: Effect) -> str:
    """Return axis, name and parameters of an effect as text."""
    values = ", ".join(f"{name} {value:.6g}" for name, value in effect.parameters().items())
    return f"{axis} {effect.name} ({values})"


def placed(model: ErrorModel, interval: float) -> list[Placed]:
    """Return the effects of a model that have a form as a step at an interval [s], in the order in which they act."""
    found = []
    for axis, own in model.axes.items():
        count: dict[str, int] = {}
        for effect in own:
            count[effect.name] = count.get(effect.name, 0) + 1
            block = effect.block(interval, axis)
            if block is not None:
                _require_numbers(describe(axis, effect), block, interval)
                label = f"{'' if effect.shared else axis} {effect.name} {count[effect.name]}"
                found.append(Placed(axis, effect, block, _key(label)))
    return found


def left_out(model: ErrorModel, interval: float) -> list[str]:
    """Return the effects that have no form as a step, as text: they act on no log, or need the run as a whole."""
    every = ((axis, effect) for axis, own in model.axes.items() for effect in own)
    return [describe(axis, effect) for axis, effect in every if effect.block(interval, axis) is None]


def program(model: ErrorModel, language: Language, rate: float, remarks: Sequence[str] = ()) -> str:
    """Return the source of a program that applies a model to one sample after the other at a rate [Hz].

    ``remarks`` are notes on the model, for its head.
    """
    effects = placed(model, 1 / rate)
    kinds = {one.kind: one for one in effects}
    context = {
        "version": __version__,
        "rate": float(rate),
        "interval": 1 / float(rate),
        "axes": log.AXES,
        "channels": CHANNELS,
        "time": log.TIME,
        "kinds": list(kinds.values()),
        "effects": effects,
        "chains": {axis: [one for one in effects if one.axis == axis] for axis in (*log.AXES, log.TIME)},
        "past": max((one.block.past for one in effects), default=0),
        "ahead": max((one.block.ahead for one in effects), default=0),
        "waiting": sorted({one.effect.name for one in effects if one.block.ahead}),
        "left_out": left_out(model, 1 / rate),
        "remarks": remarks,
    }
    return ENVIRONMENT.get_template(TEMPLATES[language]).render(context)


TEMPLATES: Mapping[Language, str] = {
    Language.PYTHON: "imu.py.jinja",
    Language.CPP: "imu.hpp.jinja",
    Language.GAZEBO_PLUGIN: "plugin.cc.jinja",
}


def _key(label: str) -> int:
    """Return 64 bits of a hash of a label."""
    return int.from_bytes(blake2b(label.encode(), digest_size=8).digest(), "little")


def _require_numbers(name: str, block: Block, interval: float) -> None:
    """Raise a ValueError where a constant of a block is not a number."""
    for key, value in block.values.items():
        if np.isnan(value).any():
            raise ValueError(f"{name}: expected constants that are numbers at {1 / interval:g} Hz; found nan for {key}")


def _plain(value: float | int | Sequence[float]) -> float | int | list[float]:
    """Return a number or list of numbers without types of NumPy."""
    if isinstance(value, int | np.integer):
        return int(value)
    return float(value) if np.ndim(value) == 0 else [float(one) for one in value]


def _python_number(value: float | int | list[float]) -> str:
    """Return a value as a literal of Python."""
    if isinstance(value, list):
        return f"[{', '.join(map(_python_number, value))}]"
    return f"{'-' if value < 0 else ''}inf" if np.isinf(value) else repr(value)


def _cpp_number(value: float | int | list[float]) -> str:
    """Return a value as a literal of C++."""
    if isinstance(value, list):
        return f"std::vector<double>{{{', '.join(map(_cpp_number, value))}}}"
    return f"{'-' if value < 0 else ''}kInfinity" if np.isinf(value) else repr(value)


def _cpp_type(value: float | int | list[float]) -> str:
    return "std::vector<double>" if isinstance(value, list) else "int" if isinstance(value, int) else "double"


def _members(own: Iterable[Placed]) -> Iterator[tuple[str, Placed]]:
    """Yield a name of each block of a chain that is its own."""
    for number, one in enumerate(own, 1):
        yield f"{one.axis}_{number}_{one.effect.name}", one


def _environment() -> Environment:
    """Return the environment of the templates."""
    # source code, no HTML: nothing is escaped
    made = Environment(
        loader=PackageLoader("imugap.interchange.code", "templates"),
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    made.filters |= {
        "python": _python_number, "cpp": _cpp_number, "cpp_type": _cpp_type, "members": lambda own: list(_members(own)),
        "to_python": to_python, "to_cpp": to_cpp,
        "summary": lambda one: (type(one.effect).__doc__ or one.effect.name).strip().splitlines()[0],
    }  # fmt: skip
    return made


ENVIRONMENT = _environment()
