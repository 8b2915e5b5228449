"""Score the simulated drives: errors of each run, of each kind of gross error, and the time to recover from it."""

import pandas as pd

from imugap.simulation.gnss_faults import OUTLIER, FaultEvent
from imugap.study.drive import fault_ablation
from imugap.study.drive.fault_ablation import CLEAN, CONTAMINATED
from imugap.workflow.job_log import job
from imugap.workflow.products import save

KEY = ["run", "case", "scheme"]


def read(paths, reader):
    """Return the parts as one table."""
    return pd.concat([reader(path) for path in paths], ignore_index=True)


def recoveries(errors, events, limit):
    """Return for each case, run, scheme and lasting event the time to recover."""
    rows, known = [], {}
    for key, one in events.groupby(["case", "run"]):
        known[key] = [FaultEvent(e.kind, e.begin, e.end, (0, 0, 0)) for e in one.itertuples()]
    errors = errors[errors["case"].isin(events["case"])]
    for (case, run, scheme), one in errors.groupby(["case", *KEY[::2]], sort=False):
        found = fault_ablation.recovery(one, known[case, run], limit)
        rows.append(found.assign(case=case, run=run, scheme=scheme))
    return pd.concat(rows)


with job(snakemake) as (source, _, output):
    errors, events = read(source.errors, pd.read_parquet), read(source.events, pd.read_csv)
    values = list(fault_ablation.ERRORS)
    scores = errors.groupby(KEY, sort=False)[[*values, "event"]].apply(fault_ablation.scores).reset_index()
    clean, spoilt = (errors[errors["case"] == case] for case in (CLEAN, CONTAMINATED))
    spoilt = spoilt.assign(event=spoilt["event"].replace("", "none"))
    kinds = spoilt.groupby(["scheme", "event"], sort=False)[values].quantile(0.95).reset_index()
    whole = clean.groupby("scheme", sort=False)[values].quantile(0.95).reset_index()
    limit = clean[clean["scheme"] == "none"]["horizontal"].quantile(0.95)
    recovery = recoveries(errors, events[events["kind"] != OUTLIER], limit).assign(limit=limit)
    scores = scores.merge(read(source.verdicts, pd.read_csv), on=KEY)
    save(output, scores=scores, kinds=pd.concat([whole.assign(event=CLEAN), kinds]), recovery=recovery)
