"""Navigate the two-dimensional example with every filter, and compare what the filters believe with what they do."""

import numpy as np
import pandas as pd

from imugap.filters.consistency import nees_band, root_mean_square
from imugap.interchange.datasheet import MODELS, TRUTHS, Slow
from imugap.navigation.planar import QUANTITIES, SCOPES, PlanarExample, covariances, monte_carlo
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def spread(drive, errors, computed):
    """Return actual, predicted and computed standard deviation of each quantity over time."""
    rows = []
    for quantity, columns in QUANTITIES.items():
        own = list(columns)
        actual, low, high = root_mean_square(errors.error[..., own])
        predicted = np.sqrt(errors.variance[..., own].mean(axis=(0, -1)))
        rows.append(pd.DataFrame({
            "quantity": quantity, "time": drive.epochs(), "predicted": predicted, "actual": actual, "low": low,
            "high": high, "computed": np.sqrt(computed[1][:, own].mean(axis=-1)),
        }))  # fmt: skip
    return pd.concat(rows)


def ends(drive, errors, computed):
    """Return actual over predicted standard deviation at the ends of the outages, and the actual one [SI]."""
    at, rows = drive.ends(), []
    for quantity, columns in QUANTITIES.items():
        where = np.ix_(range(len(errors.error)), at, list(columns))
        error, variance = errors.error[where], errors.variance[where]
        runs = len(error)
        ratio, low, high = root_mean_square((error / np.sqrt(variance)).reshape(runs, -1))
        actual, actual_low, actual_high = root_mean_square(error.reshape(runs, -1))
        predicted, true = (one[np.ix_(at, list(columns))] for one in computed)
        rows.append({
            "quantity": quantity, "ratio": ratio, "low": low, "high": high,
            "computed_ratio": np.sqrt((true / predicted).mean()), "actual": actual, "actual_low": actual_low,
            "actual_high": actual_high, "computed": np.sqrt(true.mean()),
        })  # fmt: skip
    return pd.DataFrame(rows)


def consistency(drive, errors):
    """Return the mean NEES over time with its two-sided band."""
    rows = []
    for k, (scope, states) in enumerate(SCOPES.items()):
        low, high = nees_band(states, len(errors.nees))
        rows.append(pd.DataFrame({
            "scope": scope, "states": states, "time": drive.epochs(), "nees": errors.nees[..., k].mean(axis=0),
            "low": low, "high": high,
        }))  # fmt: skip
    return pd.concat(rows)


with job(snakemake) as (source, params, output):
    example, case = PlanarExample.read(source.recipe), snakemake.wildcards.case
    truth, drive = example.models(TRUTHS[case]), example.drive
    found = []
    for title, slow in MODELS.items():
        modelled = example.models(slow)
        errors = monte_carlo(drive, truth, modelled, example.start_std, params.runs, params.seed, "planar", case)
        computed = np.full((2, *errors.error.shape[1:]), np.nan)  # missing where the truth has no state space
        if Slow.FLICKER not in TRUTHS[case]:
            computed = covariances(drive, truth, modelled, example.start_std)
        tables = spread(drive, errors, computed), ends(drive, errors, computed), consistency(drive, errors)
        found.append([table.assign(case=case, filter=title) for table in tables])
    save(output, **dict(zip(("spread", "ends", "nees"), map(pd.concat, zip(*found, strict=True)), strict=True)))
