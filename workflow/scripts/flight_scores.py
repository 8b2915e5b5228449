"""Compare the filtered attitudes of all flights with the truth."""

import pandas as pd

from imugap.io.references import reference
from imugap.kinematics.strapdown import ATTITUDE
from imugap.study.attitude import attitude_scores
from imugap.workflow.job_log import job
from imugap.workflow.products import save

KEY = ["run", "minutes", "scheme"]


with job(snakemake) as (source, params, output):
    truth, found = pd.read_parquet(source.truth), []
    for key, one in pd.concat(map(pd.read_parquet, (source.attitude, source.control))).groupby(level=KEY, sort=False):
        solution = one.droplevel(KEY)
        labels = dict(zip(KEY, key, strict=True))
        found.append(attitude_scores.scored(solution, reference.error(solution, truth), ATTITUDE, labels))
    errors, scores = map(pd.concat, zip(*found, strict=True))
    differences = attitude_scores.differences(errors[errors["minutes"] > 0], KEY[:2], ATTITUDE, params.seed)
    save(output, scores=scores, differences=differences.sort_values(KEY[:2], kind="stable"))
    errors[errors["run"] == 1].to_parquet(output.errors)
