"""Recompute the tutorial's worked example."""

import numpy as np
import pandas as pd

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.figures import farrell2022
from imugap.numerics.spectra import allan_from_psd as spectrum
from imugap.study.static.farrell2022_example import PrintedExample, checks
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

TAU = np.geomspace(0.1, 1000, 161)
NAMES = {WhiteNoise: "N", RandomWalk: "K", GaussMarkov: "B as read"}


def lines(example):
    """Return the Allan deviation (eq. 16) of the sums, and of the parts as they are read."""
    models = {"N + B + K, as read": example.model(), "N + K": example.white_and_walk(),
              "N + B + K, B at most": example.freed()}  # fmt: skip
    models |= {NAMES[type(part)]: AxisModel((part,)) for part in example.model()}
    found = {title: spectrum.allan_variance(model.state_space().psd, TAU) for title, model in models.items()}
    return {title: pd.Series(np.sqrt(variance), index=TAU) for title, variance in found.items()}


def page(found):
    """Lay the table out: printed value, recomputed value with its range, verdict."""
    for one in found:
        digits = len(str(round(one.printed / (2 * one.half_digit))))
        printed, value, low, high = (
            tables.number(number, digits + extra)
            for number, extra in ((one.printed, 0), (one.recomputed, 1), (one.low, 1), (one.high, 1))
        )
        yield {"quantity": one.quantity, "unit": one.unit.replace("^2", "²"), "printed": printed, "recomputed": value,
               "within the digits": f"{low} to {high}", "verdict": one.agreement.value}  # fmt: skip


def numbers(example, found):
    """Collect what the text quotes; lengths of the y axis in mm/s^2."""
    (floor,) = example("accelerometer", "floor")
    (alone,), (together,) = (
        [one for one in found if one.quantity.startswith(start)]
        for start in ("floor: N and K alone", "floor: N, K and the B")
    )
    place = next(one for one in found if one.quantity.startswith("place of the floor"))
    density, driving = (
        next(one for one in found if one.quantity.startswith(f"{name}: what N and K")) for name in ("B", "S_B")
    )
    lowest = np.sqrt(example.white_and_walk().allan_variance(place.recomputed))
    return {
        "floor": f"{1e3 * floor:.2f}",
        "alone": f"{1e3 * alone.recomputed:.3f}",
        "alone_range": [f"{1e3 * alone.low:.3f}", f"{1e3 * alone.high:.3f}"],
        "together": f"{1e3 * together.recomputed:.2f}",
        "excess_percent": f"{100 * (together.recomputed / floor - 1):.0f}",
        "place": f"{place.recomputed:.0f}",
        "lowest": f"{1e3 * lowest:.3f}",
        "density_printed": f"{1e3 * density.printed:.2f}",
        "density_most": f"{1e3 * density.high:.2f}",
        "density_factor": f"{density.printed / density.high:.0f}",
        "driving_factor": f"{driving.printed / driving.high:.0f}",
    }


with job(snakemake) as (source, _, output):
    printed = pd.read_csv(source.printed)
    found, example = checks(printed), PrintedExample.of(printed)
    (height,), ((low, _),) = example("accelerometer", "floor"), example.ranges("accelerometer", "floor")
    floor = (*example("accelerometer", "floor_tau"), height, height - low)
    data = pd.DataFrame([vars(one) | {"agreement": one.agreement} for one in found])
    figure = farrell2022.worked_example(lines(example), floor, example.digits(TAU))
    save(output, figure=figure, table=(data, page(found)), numbers=numbers(example, found))
