"""Choose the effects of every axis of one run, and say where the best model fails."""

import json
from pathlib import Path

import pandas as pd

from imugap import log
from imugap.estimation import goodness_of_fit
from imugap.estimation.model_selection import choose, title
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def chosen(table):
    """Return, for each axis, what was chosen, what the log cannot tell from it, and the goodness of fit by octave."""
    interval = log.interval(table)
    found, octaves = {}, []
    for axis in log.axes(table):
        sequence = table[axis].to_numpy()
        choice = choose(sequence, interval)
        fits = goodness_of_fit.of(choice.fit.model, sequence, interval)
        found[axis] = {
            "effects": title(choice.kinds),
            "estimates": choice.fit.table().reset_index().to_dict("records"),
            "alternatives": [title(other) for other in choice.alternatives],
            "verdict": fits.verdict,
            "p_value": fits.p_value,
        }
        error = (fits.table["ratio"] - 1) / fits.table["deviation"]
        octaves.append(fits.table.reset_index().assign(axis=axis, error=error.to_numpy()))
    return found, pd.concat(octaves, ignore_index=True)


with job(snakemake) as (source, _, output):
    found, octaves = chosen(log.load(source.log))
    Path(output.choice).write_text(json.dumps(found, indent=1, default=float) + "\n")
    save(output, goodness=octaves)
