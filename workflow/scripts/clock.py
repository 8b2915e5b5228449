"""Measure the sampling interval of every run relative to the first, and what it does to the indices."""

import numpy as np
import pandas as pd

from imugap import log
from imugap.figures import static
from imugap.integrity.sampling_clock import relative_interval, spectra
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def measure(paths, runs):
    """Return one row per run: the ratio by each kind of evidence and the verdict."""
    reference, rows = None, {}
    for run, path in zip(runs, paths, strict=True):
        found = spectra(log.load(path, columns=list(log.AXES)))
        reference = reference or found
        if run != runs[0]:
            rows[run] = relative_interval(reference, found).row()
    return pd.DataFrame(rows).T.rename_axis("run").reset_index()


def scatter(indices, clocks):
    """Return the relative scatter of N (gyro) over the runs, as nominal and corrected: N goes as sqrt(interval)."""
    ratio = clocks.set_index("run")["combined"].astype(float).fillna(1.0)
    white = indices[(indices["symbol"] == "N") & indices["axis"].isin(log.GYRO)].copy()
    white["corrected"] = white["value"] * np.sqrt(white["run"].map(ratio).fillna(1.0))
    spread = white.groupby("axis", sort=False)[["value", "corrected"]].agg(lambda x: x.std(ddof=1) / x.mean())
    return spread.rename(columns={"value": "nominal"})


def page(clocks):
    """Lay out the clock table."""
    shown = [
        {
            "run": row.run,
            "from lines": tables.interval(row.lines, row.lines_low, row.lines_high),
            "from the noise's roll-off": tables.interval(row.rolloff, row.rolloff_low, row.rolloff_high),
            "p (agree)": tables.number(row.agreement_p, 2),
            "combined": tables.interval(row.combined, row.combined_low, row.combined_high),
            "noise power": tables.number(row.power),
            "verdict": row.verdict,
        }
        for row in clocks.itertuples()
    ]
    return pd.DataFrame(shown)


def numbers(clocks, spread):
    """Collect what the text quotes: the extreme ratio, its effect on densities and drift, the scatter of N."""
    ratios = clocks.set_index("run")["combined"].astype(float).dropna()
    extreme = ratios.iloc[(ratios - 1).abs().argmax()] if len(ratios) else np.nan
    return {
        "evidence": bool((clocks["verdict"] != "no evidence").any()),
        "different": [int(run) for run in clocks.loc[clocks["verdict"] == "different clock", "run"]],
        "extreme_ratio": tables.number(extreme),
        "density_percent": tables.number((np.sqrt(extreme) - 1) * 100, 2),
        "walk_percent": tables.number((1 / np.sqrt(extreme) - 1) * 100, 2),
        "position_percent": tables.number((extreme**2 - 1) * 100, 2),
        "scatter_nominal_percent": [tables.number(100 * value, 2) for value in spread["nominal"]],
        "scatter_corrected_percent": [tables.number(100 * value, 2) for value in spread["corrected"]],
    }


with job(snakemake) as (source, params, output):
    clocks = measure(source.logs, params.runs)
    spread = scatter(pd.read_csv(source.indices), clocks)
    table = clocks, page(clocks)
    save(output, figure=static.clock(clocks, spread), table=table, numbers=numbers(clocks, spread))
