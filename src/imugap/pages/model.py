"""Parts of a page on an error model: how it enters a simulator and a filter."""

from collections.abc import Callable, Collection, Mapping

import yaml

from imugap.discovery.search.intervals import axis_unit
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import Rule
from imugap.interchange.export import Target, export
from imugap.model import ErrorModel
from imugap.pages.page import Block, DataTable, Fold, Part, Points, Snippet, Text, Topic
from imugap.units import habit
from imugap.workflow.tables import number, unit

SYMBOLS = {"density": "N", "density_b": "B", "density_k": "K", "correlation_time": "T"}
"""Symbols of data sheets and of IEEE 952 for parameters."""
FILTERS = (Target.KALIBR, Target.ROS, Target.KF_GINS)
SIMULATORS = (Target.GAZEBO,)


def simulator_part(model: ErrorModel, rule: Rule, comparison: tuple[Block, ...] = ()) -> Part:
    """Return the whole model, the commands that simulate it, and what a simulator of others takes of it.

    ``comparison`` is shown in a fold.
    """
    blocks: list[Block] = [
        Text(
            "The file model.yaml beside this page has the whole model. These commands simulate a device with it, and "
            "write it as a program for a simulator of your own (also python, gazebo-plugin):"
        ),
        Snippet(
            f"imugap simulate model.yaml --duration 600 --rate {rule.rate:g} --out simulated.csv\n"
            f"imugap export model.yaml --to cpp --rate {rule.rate:g} --out imu.hpp"
        ),
        Fold("The model", (Snippet(text(model)),)),
    ]
    if comparison:
        blocks.append(Fold("Its parameters before and now", comparison))
    for target in SIMULATORS:
        blocks += _exported(target, lambda one: export(model, one, rule))
    return Part("What to put into the simulator", tuple(blocks))


def asked_part(files: Mapping[str, str]) -> Part:
    """Return the files that were asked for, the text of each by its target."""
    return Part("What you asked for", tuple(Topic(f"For {target}", (Snippet(one),)) for target, one in files.items()))


def filter_part(exported: Callable[[Target], str], shown: Collection[str] = ()) -> Part:
    """Return what common filters take of a model; ``exported`` gives the text of the file of a target.

    Those that the page has ``shown`` already are left out.
    """
    blocks: list[Block] = [
        Text(
            "Filters take white noise and one slow process for each axis or triad. Each file says at its head how well "
            "it approximates the model, and what it leaves out."
        )
    ]
    for target in FILTERS:
        blocks += _exported(target, exported) if target not in shown else []
    return Part("What to write into the filter", tuple(blocks))


def parameter_table(model: ErrorModel) -> DataTable:
    """Return the parameters of a model in SI and in the units of data sheets, a row for axes that have the same."""
    alike: dict[AxisModel, list[str]] = {}
    for axis, own in model.axes.items():
        alike.setdefault(own, []).append(axis)
    rows = [
        (
            ", ".join(axes), effect.name.replace("_", " "),
            f"{key.replace('_', ' ')}{f', {SYMBOLS[key]}' if key in SYMBOLS else ''}",
            number(effect.parameters()[key]), unit(name), unit(habit(effect.parameters()[key], name)),
        )
        for own, axes in alike.items() for effect in own for key, name in effect.units(axis_unit(axes[0])).items()
    ]  # fmt: skip
    titles = ("axes", "effect", "parameter", "SI", "unit", "in data sheets")
    return DataTable("Noise and biases of the device.", titles, tuple(rows))


def text(model: ErrorModel) -> str:
    """Return a model as YAML, numbers with six digits."""
    plain = {axis: [_shortened(one) for one in effects] for axis, effects in model.to_mapping().items()}
    return yaml.safe_dump(plain, sort_keys=False, default_flow_style=None, width=70)


def _shortened(effect: dict[str, dict[str, float]]) -> dict[str, dict[str, float]]:
    return {name: {key: float(f"{value:.6g}") for key, value in one.items()} for name, one in effect.items()}


def _exported(target: Target, exported: Callable[[Target], str]) -> list[Block]:
    try:
        return [Fold(f"For {target}", (Snippet(exported(target)),))]
    except ValueError as error:
        return [Points((f"For {target}: {error}.",))]
