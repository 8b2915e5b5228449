"""Compare the filtered attitudes of all flights with the truth."""

import pandas as pd

from imugap.io import reference
from imugap.kinematics.strapdown import ATTITUDE
from imugap.stream import stream
from imugap.study import attitude_scores
from imugap.workflow.job_log import journal

KEY = ["run", "minutes", "scheme"]


def differences(errors, seed):
    """Return by how much scheme 2's variance exceeds scheme 1's on each flight alone, with intervals by blocks."""
    rows = []
    for (run, minutes), one in errors[errors["minutes"] > 0].groupby(["run", "minutes"]):
        pair = {scheme: group[list(ATTITUDE)] for scheme, group in one.groupby("scheme")}
        for angle in ATTITUDE:
            first, second = (pair[scheme][angle].to_numpy() for scheme in ("allan", "indirect"))
            found = attitude_scores.difference(first, second, stream(seed, "difference", run, minutes, angle))
            rows.append({"run": run, "minutes": minutes, "angle": angle} | vars(found) | {"differs": found.differs})
    return pd.DataFrame(rows)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        truth = pd.read_parquet(snakemake.input.truth)
        filtered = pd.concat(map(pd.read_parquet, (snakemake.input.attitude, snakemake.input.control)))
        errors, scores = [], []
        for key, one in filtered.groupby(level=KEY, sort=False):
            solution = one.droplevel(KEY)
            error = reference.error(solution, truth)
            labels = dict(zip(KEY, key, strict=True))
            nees = attitude_scores.nees(error, solution).mean()
            scores.append(attitude_scores.scores(error[list(ATTITUDE)]).reset_index().assign(nees=nees, **labels))
            errors.append(error.reset_index().assign(**labels))
        errors = pd.concat(errors)
        pd.concat(scores).to_csv(snakemake.output.scores, index=False)
        differences(errors, snakemake.params.seed).to_csv(snakemake.output.differences, index=False)
        errors[errors["run"] == 1].to_parquet(snakemake.output.errors)
