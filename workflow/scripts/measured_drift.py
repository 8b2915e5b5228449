"""Navigate every run of a device."""

import numpy as np

from imugap import log
from imugap.kinematics.free_inertial import StaticNavigation
from imugap.workflow.job_log import job


def reachable(tables, course):
    """Return the longest navigation length that every run covers after the calibration, at least that of the table."""
    shortest = min(log.duration(table) for table in tables)
    lengths = [length for length in course["horizons_s"] if course["calibration_s"] + length < shortest]
    if course["table_horizon_s"] not in lengths:
        expected = f"more than {course['calibration_s'] + course['table_horizon_s']} s in every run"
        raise log.LogError("log", "duration", expected, f"{shortest:g} s in the shortest")
    return max(lengths)


with job(snakemake) as (source, params, output):
    tables = [log.load(one, columns=list(log.AXES)) for one in source.logs]
    plan = StaticNavigation.from_mapping(params.site, params.course, reachable(tables, params.course))
    drifts = np.stack([plan.drift(table) for table in tables], axis=1)  # starts, runs, epochs, 9
    np.savez(output[0], time=plan.epochs(), drift=drifts, interval=log.interval(tables[0]))
