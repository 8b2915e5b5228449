"""Tabulate how often effects that were added to real logs are named, and how right their sizes are."""

import pandas as pd

from imu_benchmark.scores import rate
from imugap.effects import title_of
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import record_of, save


def summary(trials):
    """Return, by effect, size and number of effects together, the rates of names and of true intervals."""
    rows = []
    for (name, size, together), group in trials.groupby(["name", "size", "together"], sort=False):
        named = rate(group["named"].astype(bool))
        inside = rate(group.loc[group["named"].astype(bool), "inside"].astype(bool))
        ratio = group["ratio"].quantile([0.5, 0.25, 0.75])
        rows.append(
            {"name": name, "size": size, "together": together, "others": int(group["others"].sum())}
            | {f"named_{key}": value for key, value in named.items()}
            | {f"inside_{key}": value for key, value in inside.items()}
            | dict(zip(("ratio", "ratio_low", "ratio_high"), ratio, strict=True))
        )
    return pd.DataFrame(rows)


def page(found):
    """Lay the rates out, a row for each effect, size and number of effects."""
    return pd.DataFrame({
        "added": found["name"].map(title_of),
        "size [limits]": found["size"].map("{:g}".format),
        "together": found["together"],
        "named": [f"{round(one.named_rate * one.named_count)} of {one.named_count}" for one in found.itertuples()],
        "size over truth": [
            tables.interval(one.ratio, one.ratio_low, one.ratio_high) for one in found.itertuples()
        ],
        "truth in its interval": [
            f"{round(one.inside_rate * one.inside_count)} of {one.inside_count}" if one.inside_count else "—"
            for one in found.itertuples()
        ],
        "other names": found["others"],
    })  # fmt: skip


def numbers(trials):
    """Return what the text says."""
    clear = trials[trials["size"] == trials["size"].max()]
    alone, several = clear[clear["together"] == 1], clear[clear["together"] > 1]
    named = trials[trials["named"].astype(bool)]
    inside = named["inside"].astype(bool)
    by_name = inside.groupby(named["name"], sort=False).agg(["sum", "size"])
    shares = {"alone": rate(alone["named"].astype(bool)), "several": rate(several["named"].astype(bool)),
              "inside": rate(inside)}  # fmt: skip
    alone_by_name = trials["name"].where(trials["together"] == 1, "")  # effects added together are one trial
    others = trials.groupby(["device", "run", "axis", "size", "together", alone_by_name])["others"].first()
    return {
        "devices": trials["device"].drop_duplicates().tolist(),
        "clear": f"{clear['size'].iloc[0]:g}",
        "logs": len(trials.drop_duplicates(["device", "run", "axis"])),
        "most": int(trials["together"].max()),
        "others": int((others > 0).sum()),
        "trials": len(others),
        "inside_by_name": [
            {"name": title_of(one.Index), "right": int(one.sum), "count": int(one.size)} for one in by_name.itertuples()
        ],
    } | {
        name: {"count": one["count"], "right": round(one["count"] * one["rate"])}
        | {end: f"{100 * one[end]:.0f}" for end in ("rate", "low", "high")}
        for name, one in shares.items()
    }


with job(snakemake) as (source, _, output):
    trials = pd.read_csv(source.trials)
    found = summary(trials)
    save(output, table=(found, page(found)), numbers=numbers(trials) | record_of(dict(source.items())))
