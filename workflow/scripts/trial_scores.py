"""Measure how log and reference of every trial lie to one another, and compare the filtered attitudes with it."""

import pandas as pd

from imugap import log
from imugap.io.references import reference
from imugap.kinematics.strapdown import level
from imugap.numerics.rotation import from_euler, to_euler
from imugap.study.attitude import attitude_scores
from imugap.workflow.job_log import job
from imugap.workflow.products import save

KEY = ["trial", "model", "scheme"]


def measure(table, known, margin):
    """Return what motion says of clock and axes, and what the first rest adds: change of biases, tilt of the level."""
    found = reference.alignment(table, known)
    rest, _ = reference.rests(table, known, margin)
    means = rest.mean()
    for axis in log.GYRO:
        found.loc[f"change_{axis[-1]}"] = found.loc[f"bias_{axis[-1]}"] - means[axis]
    true = reference.rotations(known.loc[rest.index[0] : rest.index[-1]]).mean()
    levelled = from_euler([*level(means[list(log.ACCEL)]), to_euler(true)[2]])
    for name, value in zip(("north", "east"), (levelled * true.inv()).as_rotvec(), strict=False):
        found.loc[f"tilt_{name}"] = value
    return found


with job(snakemake) as (source, params, output):
    filtered, alignments, found = pd.read_parquet(source.attitude), [], []
    for trial, log_path, reference_path in zip(params.trials, source.logs, source.references, strict=True):
        known = pd.read_parquet(reference_path)
        measured = measure(log.load(log_path), known, params.margin_s)
        alignments.append(measured.reset_index().assign(trial=trial))
        for key, one in filtered.loc[trial].groupby(level=KEY[1:], sort=False):
            solution = one.droplevel(KEY[1:])
            error = reference.error(solution, known, measured.loc["lag", "value"])
            labels = dict(zip(KEY, (trial, *key), strict=True))
            found.append(attitude_scores.scored(solution, error, reference.ERROR, labels))
    errors, scores = map(pd.concat, zip(*found, strict=True))
    differences = attitude_scores.differences(errors, KEY[:2], reference.ERROR, params.seed)
    save(output, alignment=pd.concat(alignments), scores=scores, differences=differences)
    errors.to_parquet(output.errors)
