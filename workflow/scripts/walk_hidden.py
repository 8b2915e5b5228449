"""Name one hidden effect at a time in simulated loops: by discovery with the exact reference, and by zero velocity."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import yaml

from imugap.discovery.device import Settings, discover
from imugap.discovery.preparation.prepare import prepare
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel
from imugap.navigation.walk.stance_innovations import stance_test
from imugap.simulation.walk import Walk, WalkCourse
from imugap.study.walk.walk_compensation import known_assumptions
from imugap.workflow.job_log import job

RATE_HZ = 100


def hidden(walk, case):
    """Return the walk with what a case hides in device and foot."""
    effects = {axis: one for axis, one in case.items() if axis != "gait"}
    extra = ErrorModel.from_mapping(effects).axes
    axes = {axis: model + extra.get(axis, AxisModel()) for axis, model in walk.model.axes.items()}
    axes |= {axis: model for axis, model in extra.items() if axis not in axes}
    return replace(walk, model=ErrorModel(axes), gait=replace(walk.gait, **case.get("gait", {})))


def main(walk, case, params):
    """Return findings and places with the exact reference, what integrity finds alone, and what zero velocity says."""
    loop = replace(walk, rate_hz=RATE_HZ, course=WalkCourse.loop(params.strides, stand_s=walk.course.stand_s))
    device = hidden(loop, case)
    log, ideal = device.record(1, params.seed), device.ideal(1, params.seed)
    settings = Settings(seed=params.seed, **params.settings)
    found = discover([log], settings, reference=ideal)
    rows = [
        {"how": how, "name": one.name, "axis": " ".join(one.axes)}
        for how, findings in {"exact": found.findings, "integrity": prepare(log).findings}.items()
        for one in findings
    ]
    places = {
        (place.axis, place.view): place for place in sorted(found.discrepancies, key=lambda place: -place.p_value)
    }
    rows += [
        {"how": "place", "name": place.view, "axis": place.axis, "value": place.low, "high": place.high,
         "unit": place.unit, "chance": place.p_value}
        for place in places.values()
    ]  # fmt: skip
    said = stance_test(log, loop.model, known_assumptions(loop))
    rows.append({"how": "scatter", "value": said.scatter})
    rows += [{"how": "innovations"} | one for one in said.named(params.settings["alpha"]).to_dict("records")]
    return pd.DataFrame(rows)


with job(snakemake) as (source, params, output):
    walk, known = Walk.read(source.recipe), yaml.safe_load(Path(source.cases).read_text())
    for case, path in zip(params.cases, output, strict=True):
        main(walk, known[case], params).to_csv(path, index=False)
