"""Report of a discovery in Markdown; it shows the figures that lie beside it."""

import pandas as pd

from imugap.discovery.inputs import FileDiscovery
from imugap.discovery.posterior import percent
from imugap.discovery.start_comparison.wording import sentences
from imugap.discovery.verdict import describe_range, verdict
from imugap.units import with_unit

LEAST = 1e-300
"""Probability below which no number is given."""


def text(result: FileDiscovery, kind: str = "svg") -> str:
    """Return the report to read, in Markdown; it shows the figures of a format that lie beside it."""
    found = result.found
    logs = [f"- {role}: `{one['path']}`, {one['duration_s']:.6g} s at {one['rate_hz']:.6g} Hz; its first stamp, "
            f"{one['begin_s']:.10g} s, is time zero here"
            + "".join(f"; {sentence}" for sentence in result.recognised.get(one["path"], ()))
            for role, some in (("log", result.logs), ("test", result.tests)) for one in some]  # fmt: skip
    advice = (one.sentence() for one in result.advice)
    held_out = "the test logs" if result.tests else "the last part of the log"
    parts = [
        "# Where simulation and measurement disagree, and what is missing",
        "\n".join(logs),
        "## Verdict",
        "\n".join(f"- {line}" for line in (*verdict(found).splitlines(), *sentences(result.against), *advice)),
        "## Effects",
        _table(_effects(result)),
        "## Places",
        "Where the log leaves the start model:",
        _table(_places(found.discrepancies)),
        "Where it leaves the final model:",
        _table(_places(found.unexplained)),
        f"![The surest place of each view before and after](surest.{kind})",
        f"![Each place before and after](places.{kind})\n\nViews with a place, before (start model, training part) and "
        f"after (final model, whole log). Line: the log. Band: where {1 - result.alpha:.0%} of simulated logs stay "
        "everywhere. Bars: the places. Probabilities much below one in a hundred are extrapolated from simulations.",
        "## Distance",
        f"On {held_out}. The floor is how far simulations of the final model are from each other.",
        _table(_distances(result)),
        f"![Distance before and after](distance.{kind})",
        f"![Navigation drift before and after](drift.{kind})",
    ]  # fmt: skip
    return "\n\n".join(parts) + "\n"


def _effects(result: FileDiscovery) -> pd.DataFrame:
    rows = [
        (
            ", ".join(one.axes),
            one.name,
            "; ".join(with_unit(f"{name} {_interval(end)}", end.unit) for name, end in one.parameters.items()),
            percent(one.probabilities[one.name]),
            ", ".join(name for name, _ in one.alternatives) or "-",
        )
        for one in result.found.findings
    ]
    return pd.DataFrame(rows, columns=["axes", "name", "parameters (95 %)", "probability", "not distinguished from it"])


def _places(discrepancies) -> pd.DataFrame:
    rows = [
        (place.axis, place.view, describe_range(place), f"{place.p_value:.1e}" if place.p_value else f"< {LEAST:.0e}")
        for place in discrepancies
    ]
    return pd.DataFrame(rows, columns=["axis", "view", "where", "p-value"])


def _distances(result: FileDiscovery) -> pd.DataFrame:
    rows = [
        (name, *(_interval(getattr(apart, state)) for state in ("before", "after", "floor")))
        for name, apart in result.found.distances.items()
    ]
    return pd.DataFrame(rows, columns=["distance", "before", "after", "floor"])


def _interval(one) -> str:
    return f"{one.value:.4g} [{one.low:.4g}, {one.high:.4g}]"


def _table(table: pd.DataFrame) -> str:
    """Return a table in Markdown, or that there is nothing."""
    if table.empty:
        return "Nothing."
    rows = [list(table.columns), ["---"] * len(table.columns), *table.to_numpy().tolist()]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in rows)
