"""Measure how log and reference of every trial lie to one another, and compare the filtered attitudes with it."""

import pandas as pd

from imugap import log
from imugap.io import reference
from imugap.kinematics.strapdown import level
from imugap.numerics.rotation import from_euler, to_euler
from imugap.stream import stream
from imugap.study import attitude_scores
from imugap.workflow.job_log import journal

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


def differences(errors, seed):
    """Return by how much scheme 2's variance exceeds scheme 1's, with block-bootstrap intervals."""
    rows = []
    for (trial, model), one in errors.groupby(["trial", "model"], sort=False):
        pair = dict(list(one.groupby("scheme")))
        for angle in reference.ERROR:
            first, second = (pair[scheme][angle].to_numpy() for scheme in ("allan", "indirect"))
            found = attitude_scores.difference(first, second, stream(seed, "difference", trial, model, angle))
            rows.append({"trial": trial, "model": model, "angle": angle} | vars(found) | {"differs": found.differs})
    return pd.DataFrame(rows)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, output, params = snakemake.input, snakemake.output, snakemake.params
        filtered, alignments, errors, scores = pd.read_parquet(source.attitude), [], [], []
        for trial, log_path, reference_path in zip(params.trials, source.logs, source.references, strict=True):
            known = pd.read_parquet(reference_path)
            measured = measure(log.load(log_path), known, params.margin_s)
            alignments.append(measured.reset_index().assign(trial=trial))
            for (model, scheme), one in filtered.loc[trial].groupby(level=["model", "scheme"], sort=False):
                solution = one.droplevel(["model", "scheme"])
                error = reference.error(solution, known, measured.loc["lag", "value"])
                labels = {"trial": trial, "model": model, "scheme": scheme}
                nees = attitude_scores.nees(error, solution).mean()
                found = attitude_scores.scores(error[list(reference.ERROR)])
                scores.append(found.reset_index().assign(nees=nees, **labels))
                errors.append(error.reset_index().assign(**labels))
        errors = pd.concat(errors)
        pd.concat(alignments).to_csv(output.alignment, index=False)
        pd.concat(scores).to_csv(output.scores, index=False)
        differences(errors, params.seed).to_csv(output.differences, index=False)
        errors.to_parquet(output.errors)
