"""Count how often the ellipse of the end holds the true one, over simulated loops."""

from dataclasses import asdict, replace

import pandas as pd

from imugap.navigation.walk.pedestrian import WalkAssumptions, navigate
from imugap.simulation.matched_walk import simulated_walk
from imugap.simulation.walk import Walk, WalkCourse
from imugap.study.walk.walk_compensation import End, known_assumptions
from imugap.workflow.job_log import job
from imugap.workflow.products import save

END_S = 0.4
"""Stand at the end of the loop: too short to be taken for one."""


def main(walk, params):
    """Return the ends of loops of a foot that does what the filter assumes, and of one that slips as a foot does."""
    loop = replace(walk, course=replace(WalkCourse.loop(params.strides, stand_s=walk.course.stand_s), end_s=END_S))
    smooth = replace(loop.gait, drift_m_per_s=0.0, impact_m_per_s2=0.0)
    as_assumed = replace(known_assumptions(walk), motion_std=0.0, blind_gyro=0.0, blind_accel=0.0, tilt_std=1e-4)
    usual, rows = WalkAssumptions(gravity=walk.site.gravity), []
    for run in range(1, params.walks + 1):
        ideal = replace(loop, gait=smooth)
        log, velocity = simulated_walk(ideal, as_assumed, run, params.seed)
        found = navigate(log, walk.model, as_assumed, velocity=velocity)
        rows.append({"foot": "as assumed", "run": run} | asdict(End.of(found, ideal.truth(run, params.seed))))
        found = navigate(loop.record(run, params.seed), walk.model, usual)
        rows.append({"foot": "slipping", "run": run} | asdict(End.of(found, loop.truth(run, params.seed))))
    return pd.DataFrame(rows)


with job(snakemake) as (source, params, output):
    save(output, ends=main(Walk.read(source.recipe), params))
