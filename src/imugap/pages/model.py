"""Parts of a page on an error model: how it enters a simulator and a filter."""

from collections.abc import Callable

import yaml

from imugap.interchange.conventions import Rule
from imugap.interchange.export import Target, export
from imugap.model import ErrorModel
from imugap.pages.page import Block, Fold, Part, Points, Snippet, Text

FILTERS = (Target.KALIBR, Target.ROS, Target.KF_GINS)
SIMULATORS = (Target.GAZEBO,)


def simulator_part(model: ErrorModel, rule: Rule) -> Part:
    """Return the whole model, the command that simulates it, and what a simulator of others takes of it."""
    blocks: list[Block] = [
        Text("The model, as the file model.yaml has it. This command simulates a device with it:"),
        Snippet(f"imugap simulate model.yaml --duration 600 --rate {rule.rate:g} --out simulated.csv"),
        Fold("model.yaml", (Snippet(text(model)),)),
    ]
    for target in SIMULATORS:
        blocks += _exported(target, lambda one: export(model, one, rule))
    return Part("What to put into the simulator", tuple(blocks))


def filter_part(exported: Callable[[Target], str]) -> Part:
    """Return what common filters take of a model; ``exported`` gives the text of the file of a target."""
    blocks: list[Block] = [
        Text(
            "Filters take white noise and one slow process for each axis or triad. Each file says at its head how well "
            "it approximates the model, and what it leaves out."
        )
    ]
    for target in FILTERS:
        blocks += _exported(target, exported)
    return Part("What to write into the filter", tuple(blocks))


def text(model: ErrorModel) -> str:
    """Return a model as YAML."""
    return yaml.safe_dump(model.to_mapping(), sort_keys=False, default_flow_style=None, width=70)


def _exported(target: Target, exported: Callable[[Target], str]) -> list[Block]:
    try:
        return [Fold(f"For {target}", (Snippet(exported(target)),))]
    except ValueError as error:
        return [Points((f"For {target}: {error}.",))]
