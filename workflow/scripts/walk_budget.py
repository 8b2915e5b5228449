"""Navigate simulated walks with all errors of a device, and without one at a time, for the error budget of the end."""

from dataclasses import replace
from itertools import product

import pandas as pd

from imugap.analysis.walk import DEFAULT_MODEL
from imugap.kinematics.strapdown import POSITION
from imugap.model import ErrorModel, conditions
from imugap.navigation.walk.pedestrian import WalkAssumptions, navigate
from imugap.simulation.matched_walk import STANCE_MOTION, DeviceClass, without
from imugap.simulation.walk import Gait, Walk, WalkCourse, WalkLeg
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

ALL, NONE = ("all", "all"), ("none", "none")
LOOP = 60
"""Strides of the embedded loop."""


def walks(path, like):
    """Return the walks by name: the twins of a file, or without one the embedded walk and a loop."""
    if path is None:
        return {"out and back": like, "loop": replace(like, course=WalkCourse.loop(LOOP))}
    found = {}
    for run, one in read_json(path).items():
        course = one["course"] | {"legs": tuple(WalkLeg(**leg) for leg in one["course"]["legs"])}
        found[run] = replace(like, gait=Gait(**one["gait"]), course=WalkCourse(**course), rate_hz=one["rate_hz"])
    return found


def errors(walk, name, kind, draw, seed):
    """Yield (triad, effect) and the error of the end [m] with all but that effect, with all, and with none."""
    still = replace(walk, gait=replace(walk.gait, drift_m_per_s=0.0))
    device = kind.draw(seed, "device", name, draw)
    assumptions = WalkAssumptions(gravity=walk.site.gravity)

    def ender(of):
        ideal, true = of.ideal(draw, seed), of.truth(draw, seed)[list(POSITION)].iloc[-1].to_numpy(float)
        at = conditions(ideal)

        def end(model):
            log = model.simulate(ideal, seed, "twin", name, draw, at=at)
            found = navigate(log, DEFAULT_MODEL, assumptions).trajectory
            return found[list(POSITION)].iloc[-1].to_numpy() - true

        return end

    end = ender(walk)
    yield ALL, end(device)
    for triad, effect in kind.names():
        yield (triad, effect), end(without(device, triad, effect))
    end = ender(still)
    yield ("foot", STANCE_MOTION), end(device)
    yield NONE, end(ErrorModel({}))


with job(snakemake) as (source, params, output):
    like, kind, rows = Walk.read(source.recipe), DeviceClass.read(source.kind), []
    for (name, walk), draw in product(walks(source.get("twins"), like).items(), range(1, params.draws + 1)):
        for (triad, effect), off in errors(walk, name, kind, draw, params.seed):
            labels = {"walk": name, "draw": draw, "triad": triad, "effect": effect}
            rows.append(labels | dict(zip(POSITION, off, strict=True)))
    save(output, errors=pd.DataFrame(rows))
