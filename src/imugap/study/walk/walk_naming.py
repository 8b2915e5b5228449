"""Score the names given to effects that were hidden in simulated walks, by source of the name.

Sources: ``exact`` (discovery with the error-free log), ``integrity`` (stamps and samples of the log alone) and
``innovations`` (zero velocity at stance).
"""

import pandas as pd

SOURCES = ("exact", "integrity", "innovations")
NOT_OF_THE_DEVICE = ("nothing", "stance_motion")
"""Cases in which no effect of the device is hidden: any name is wrong."""


def score(found: pd.DataFrame, hidden: dict[str, tuple[str, list[str]]]) -> pd.DataFrame:
    """Score each case and source.

    Parameters
    ----------
    found
        Columns case, how (a source, or ``scatter``), name, value, deviate; a row for each name that is given, the
        most significant first. Names of one source are one effect: indistinguishable candidates.
    hidden
        Case -> name and axes of what it hides.

    Returns
    -------
    pandas.DataFrame
        A row for each case: hidden, axes, there (whether the device has an effect), scatter, and for each source
        ``_right`` (the hidden name is given, or none where there is none) and ``_wrong`` (names are given, and the
        hidden one is not among them; with the exact reference: any other name is given), and for the innovations the
        ``deviate`` of a wrong name, in standard deviations.
    """
    rows = []
    for case, one in found.groupby("case", sort=False):
        name, axes = hidden[case]
        there = case not in NOT_OF_THE_DEVICE
        row = {"case": case, "hidden": name, "axes": " ".join(axes), "there": there}
        row["scatter"] = float(one.loc[one["how"] == "scatter", "value"].iloc[0])
        for source in SOURCES:
            part = one[one["how"] == source]
            right = there and name in set(part["name"])
            others = set(part["name"]) - ({name} if there else set())
            row[f"{source}_right"] = right if there else part.empty
            row[f"{source}_wrong"] = bool(others) and (source == "exact" or not right)
            if source == "innovations":
                row["deviate"] = abs(float(part["deviate"].iloc[0])) if row["innovations_wrong"] else float("nan")
        rows.append(row)
    return pd.DataFrame(rows)


def summary(scores: pd.DataFrame) -> dict:
    """Count right and wrong names by source, where the device has an effect (``there``) and where it has none."""
    there, absent = scores[scores["there"]], scores[~scores["there"]]
    counts = {
        source: {
            "right": int(there[f"{source}_right"].sum()),
            "wrong": int(there[f"{source}_wrong"].sum()),
            "false": int(absent[f"{source}_wrong"].sum()),
        }
        for source in SOURCES
    }
    largest = scores["deviate"].max()
    return {"cases": len(scores), "there": len(there), "absent": len(absent)} | counts | {
        "largest_wrong_sigma": None if pd.isna(largest) else f"{largest:.1f}"
    }  # fmt: skip
