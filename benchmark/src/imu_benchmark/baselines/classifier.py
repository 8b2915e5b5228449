"""Baseline that learns: a forest of trees of scikit-learn on features of simulated cases.

The cases that it learns from come from the recipe of this package with the seed :data:`SEED`, and never from a
benchmark. Each axis is an example, whose class is the name of the effect hidden there, or none. It gives probabilities.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from sklearn.ensemble import ExtraTreesClassifier

from imu_benchmark import recipe as recipes
from imu_benchmark.baselines import features
from imu_benchmark.baselines.findings import answer, effect
from imu_benchmark.case import Case
from imu_benchmark.log import AXES, TIME
from imu_benchmark.scores import NONE
from imu_benchmark.sealing import SealedCase, plan, seal

SEED = 1
CASES = 600
LENGTHS = {"duration_s": [300, 900], "rates_hz": [25]}
"""What the cases differ in from the recipe, to be made in minutes."""
SHARES = {"single": 0.85, "nothing": 0.15}
TREES = 500
SURE = 0.5
"""Least probability of a name that is given, and of none where no place is."""


@dataclass(frozen=True, eq=False)
class Classifier:
    """A trained forest, and the names that act on stamps and rows of all axes."""

    forest: ExtraTreesClassifier
    of_time: frozenset[str]

    def probabilities(self, case: Case, axis: str) -> dict[str, float]:
        """Return the probabilities of the names, the likeliest first."""
        (weights,) = self.forest.predict_proba([features.of_axis(case, axis)])
        order = np.argsort(-weights, kind="stable")
        return {str(self.forest.classes_[number]): float(weights[number]) for number in order if weights[number] > 0}

    def report(self, case: Case) -> dict:
        """Return the names that are likelier than all others together, and places where something is without one."""
        found = {axis: self.probabilities(case, axis) for axis in case.axes}
        named: dict[str, list[str]] = {}
        places = []
        for axis, weights in sorted(found.items(), key=lambda item: -max(item[1].values())):
            top, weight = next(iter(weights.items()))
            if weight > SURE and top != NONE:
                named.setdefault(top, []).append(axis)
            elif weights.get(NONE, 0.0) < SURE:
                places.append({"axis": axis, "probabilities": weights})
        effects = [
            effect(name, [TIME] if name in self.of_time else axes, probabilities=found[axes[0]])
            for name, axes in named.items()
        ]
        surest = max(found.values(), key=lambda weights: 1 - weights.get(NONE, 0.0))
        return answer(effects, places) | {"probabilities": surest}


def report(case: Case) -> dict:
    """Return what the forest finds."""
    return trained().report(case)


@cache
def trained(cases: int = CASES) -> Classifier:
    """Simulate cases and train the forest on them."""
    recipe = recipes.read() | LENGTHS | {"motion_duration_s": LENGTHS["duration_s"], "shares": SHARES}
    examples: list[tuple[np.ndarray, str]] = []
    of_time: set[str] = set()
    for planned in plan(SEED, cases, recipe):
        sealed = seal(planned, recipe)
        of_time |= {one["name"] for one in sealed.key["effects"] if one["axes"] == [TIME]}
        examples += _examples(sealed)
    values, names = zip(*examples, strict=True)
    forest = ExtraTreesClassifier(TREES, random_state=SEED).fit(np.array(values), names)
    return Classifier(forest, frozenset(of_time))


def _examples(sealed: SealedCase) -> list[tuple[np.ndarray, str]]:
    """Return features and name of each axis of a case; effects on stamps and rows belong to all axes."""
    case = Case(sealed.key["case"], sealed.logs, sealed.reference, sealed.model or {})
    names = {
        axis: one["name"] for one in sealed.key["effects"] for axis in (AXES if one["axes"] == [TIME] else one["axes"])
    }
    return [(features.of_axis(case, axis), names.get(axis, NONE)) for axis in case.axes]
