"""Limits of detection, from the recorded run of the blind benchmark."""

import pandas as pd

from imu_benchmark.scores import ALL, detection, false_alarms
from imugap.site.markdown import code, table


def page(cases: pd.DataFrame, effects: pd.DataFrame) -> str:
    """Return how often an effect is found and named, by size, and how often a name is given where nothing is hidden."""
    found = detection(effects)
    sizes = sorted(found["size"].unique())
    alarms = false_alarms(cases).set_index("alarm")
    quiet = alarms.loc["name"]
    rows = [
        (code(name) if name != ALL else "all", *(_share(of[of["size"] == size]) for size in sizes))
        for name, of in found[found["score"] == "named"].groupby("name", sort=False)
    ]
    titles = ("effect", *(f"size {size:g}" for size in sizes))
    return (
        f"Of {quiet['count']:.0f} logs that hide nothing, {100 * quiet['rate']:.0f} % get a name (95 % interval "
        f"{100 * quiet['low']:.0f} % to {100 * quiet['high']:.0f} %).\n\n"
        "Right names of all cases with one hidden effect:\n\n" + table(titles, rows) + "\n"
    )


def _share(of: pd.DataFrame) -> str:
    if of.empty:
        return ""
    one = of.iloc[0]
    return f"{one['rate'] * one['count']:.0f} of {one['count']:.0f}"
