"""Collect the integrity reports of a device."""

import pandas as pd

from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save


def page_row(run, facts):
    """Show one run: what a reader has to know before using it."""
    timing, gravity, axes = facts["timing"], facts["gravity"], facts["axes"]
    lattices = {kind: [a["lattice"] for a in axes if a["axis"].startswith(kind)] for kind in ("gyro", "accel")}
    flagged = [a["axis"] for a in axes if a["stuck"] or a["saturated"]]
    events = facts["events"]
    times = ", ".join(f"{event['start_s']:.0f}" for event in events[:3]) + (", …" if len(events) > 3 else "")
    return {
        "run": run,
        "rate [Hz]": tables.number(timing["rate_hz"], 6),
        "length [s]": f"{timing['duration_s']:.0f}",
        "gaps": timing["gaps"],
        "repeated / reversed stamps": f"{timing['duplicated']} / {timing['reversed']}",
        "NaN": sum(a["nan"] for a in axes),
        "gyro step [°/s]": step(lattices["gyro"], "deg/s"),
        "accel step [mg]": step(lattices["accel"], "mg"),
        "stuck or saturated": ", ".join(flagged) or "none",
        "knocks (at s)": f"{len(events)} ({times})" if events else "0",
        "specific force [m/s²]": tables.number(gravity["norm"], 5) if gravity else "—",
    }


def step(lattices, unit):
    """Show the coarsest value lattice of a triad, or that its values are continuous."""
    known = [value for value in lattices if value]
    return tables.number(from_si(max(known), unit)) if known else "none"


def sound(facts):
    """Return whether a run has no gap, no repeated or reversed stamp, no missing value, no stuck or saturated axis."""
    timing, axes = facts["timing"], facts["axes"]
    faults = [timing[name] for name in ("gaps", "duplicated", "reversed")]
    return not any([*faults, *(one[name] for one in axes for name in ("nan", "stuck", "saturated"))])


with job(snakemake) as (source, params, output):
    runs = dict(zip(params.runs, map(read_json, source.reports), strict=True))
    data = pd.concat(
        pd.DataFrame(facts["axes"]).assign(run=run, **facts["timing"], knocks=len(facts["events"]))
        for run, facts in runs.items()
    )
    numbers = {"runs": len(runs), "sound": sum(map(sound, runs.values()))}
    save(output, table=(data, [page_row(run, facts) for run, facts in runs.items()]), numbers=numbers)
