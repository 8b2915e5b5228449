"""Score the simulated drives: errors of each run, of each kind of gross error, and the time to recover from it."""

import pandas as pd

from imugap.simulation.gnss_faults import OUTLIER, FaultEvent
from imugap.study import fault_ablation
from imugap.study.fault_ablation import CLEAN, CONTAMINATED
from imugap.workflow.job_log import journal

KEY = ["run", "case", "scheme"]


def read(paths, reader):
    """Return the parts as one table."""
    return pd.concat([reader(path) for path in paths], ignore_index=True)


def recoveries(errors, events, limit):
    """Return for each case, run, scheme and lasting event the time to recover."""
    rows, known = [], {}
    for key, one in events.groupby(["case", "run"]):
        known[key] = [FaultEvent(e.kind, e.begin, e.end, (0, 0, 0)) for e in one.itertuples()]
    for (case, run, scheme), one in errors[errors["case"].isin(events["case"])].groupby(
        ["case", *KEY[::2]], sort=False
    ):
        found = fault_ablation.recovery(one, known[case, run], limit)
        rows.append(found.assign(case=case, run=run, scheme=scheme))
    return pd.concat(rows)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, output = snakemake.input, snakemake.output
        errors, events = read(source.errors, pd.read_parquet), read(source.events, pd.read_csv)
        found = (
            errors.groupby(KEY, sort=False)[[*fault_ablation.ERRORS, "event"]]
            .apply(fault_ablation.scores)
            .reset_index()
        )
        found.merge(read(source.verdicts, pd.read_csv), on=KEY).to_csv(output.scores, index=False)
        clean, spoilt = (errors[errors["case"] == case] for case in (CLEAN, CONTAMINATED))
        spoilt = spoilt.assign(event=spoilt["event"].replace("", "none"))
        kinds = (
            spoilt.groupby(["scheme", "event"], sort=False)[list(fault_ablation.ERRORS)].quantile(0.95).reset_index()
        )
        whole = clean.groupby("scheme", sort=False)[list(fault_ablation.ERRORS)].quantile(0.95).reset_index()
        pd.concat([whole.assign(event=CLEAN), kinds]).to_csv(output.kinds, index=False)
        limit = clean[clean["scheme"] == "none"]["horizontal"].quantile(0.95)
        found = recoveries(errors, events[events["kind"] != OUTLIER], limit)
        found.assign(limit=limit).to_csv(output.recovery, index=False)
