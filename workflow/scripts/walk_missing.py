"""Name the errors that real walks show, and predict the ends of the walks that did not estimate them."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from imugap.analysis.walk import DEFAULT_MODEL
from imugap.effects import CATALOGUE
from imugap.integrity.timestamps import filled
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.io.catalogue.datasets import RawFiles
from imugap.kinematics.strapdown import POSITION
from imugap.model import ErrorModel, conditions
from imugap.navigation.walk.pedestrian import WalkAssumptions
from imugap.navigation.walk.score_test import BlockScores, block_scores, score_test
from imugap.navigation.walk.stance_innovations import candidate_errors, foot_sinkage
from imugap.simulation.camera_track import closed_loop_aiding, compare_with_cameras
from imugap.simulation.matched_walk import AT_REST, DeviceClass
from imugap.simulation.walk import Walk
from imugap.simulation.walk_replay import Replay
from imugap.stream import stream
from imugap.workflow.job_log import job
from imugap.workflow.products import save

CANDIDATES = (*candidate_errors(), foot_sinkage())
SINKAGE = len(CANDIDATES) - 1
"""Effect of the foot and not of the device: walks with other devices estimate it too."""
HALVES = {1: "odd", 0: "even"}
"""Half of the walks that estimates, by the remainder of their number by two."""
REST, SHEET, NAMED, SHARED = "at rest", "data sheet", "named", "other sets"
"""Sources of a prediction: noise and turn-on biases; all errors of data sheets; noise, turn-on biases and the error
named on other walks of the device; these and the error named on walks of other sets."""


@dataclass(frozen=True, eq=False)
class ObservedWalk:
    """A walk of a set: its replay, the measured error of its end [m], shape (3,), and its block scores."""

    dataset: str
    run: int
    replay: Replay
    end: np.ndarray
    scores: BlockScores

    @classmethod
    def of(cls, files, run):
        """Read and navigate a walk, and score the candidates."""
        dataset = files.dataset
        log, seen = filled(readers.read_raw(files.path(run), dataset, run)), bool(dataset.positions)
        replay = Replay.of(log, DEFAULT_MODEL, WalkAssumptions(), seen)
        aiding = closed_loop_aiding(replay.solution)
        end = replay.solution.trajectory[list(POSITION)].iloc[-1].to_numpy()
        if seen:
            comparison = compare_with_cameras(replay.solution, readers.positions_of(files, run))
            aiding, end = comparison.aiding(replay.solution), comparison.off
        scores = block_scores(log, aiding, CANDIDATES, DEFAULT_MODEL)
        return cls(dataset.name, run, replay, end, scores)


def total_scores(walks):
    """Return the scores of all walks."""
    total, *others = (walk.scores for walk in walks)
    for one in others:
        total = total + one
    return total


def label(number):
    """Return name, axis and parameter of a candidate as text."""
    one = CANDIDATES[number]
    axis = "accel" if len(one.axes) > 1 else one.axes[0]
    return f"{one.name} {axis}" + (f" to {one.parameter}" if len(one.parameter) == 1 else "")


def rows_of(verdict, labels):
    """Return a row for each named effect, the most likely first, or one for the most significant candidate."""
    labels = labels | {"p_value": verdict.p_value}
    if not verdict.named:
        return [labels | {"suspect": label(verdict.most_significant), "named": False}]
    rows = []
    for one in verdict.named:
        candidate = CANDIDATES[one.number]
        unit = CATALOGUE[candidate.name].units("")[candidate.parameter]
        row = {"suspect": label(one.number), "named": True, "name": candidate.name, "axis": " ".join(candidate.axes)}
        row |= {"parameter": candidate.parameter, "unit": unit, "value": one.value, "low": one.low, "high": one.high}
        rows.append(labels | row)
    return rows


def end_shift(walk, number):
    """Return the displacement of the end of a walk per unit of a candidate, shape (3,)."""
    one = CANDIDATES[number]
    if one.velocity is None:
        return walk.replay.end(one.model, walk.replay.still(), 0) / one.small
    return walk.replay.end(ErrorModel({}), walk.replay.sink(one.small), 0) / one.small


def predictions(walk, known, kind, slip, params):
    """Yield each source of a prediction, and its draws of the end [m], shape (draws, 3)."""
    labels = walk.dataset, walk.run
    steps = [walk.replay.slip(slip, stream(params.seed, "slip", *labels, draw)) for draw in range(params.draws)]
    at = conditions(walk.replay.log)

    def draws(of, name):
        devices = (of.draw(params.seed, "device", *labels, draw) for draw in range(params.draws))
        ends = [
            walk.replay.end(device, step, params.seed, "replay", *labels, draw, at=at)
            for draw, (device, step) in enumerate(zip(devices, steps, strict=True))
        ]
        return name, np.array(ends)

    rest, base = draws(kind.only(AT_REST), REST)
    yield rest, base
    yield draws(kind, SHEET)
    for name, named in known.items():
        yield name, base + end_shifts(walk, named, stream(params.seed, "size", name, *labels), len(base))


def end_shifts(walk, named, rng, count):
    """Draw displacements of the end by the named effect, shape (count, 3); indistinguishable ones have equal shares."""
    by = np.zeros((count, len(POSITION)))
    for place, one in enumerate(named):
        rows = slice(place, None, len(named))
        by[rows] = np.outer(one.value + one.std * rng.standard_normal(len(by[rows])), end_shift(walk, one.number))
    return by


def names_by_half(walks, remainder, params):
    """Return the names of each set by one half of its walks, and the effect of the foot by the other sets."""
    half = [walk for walk in walks if walk.run % 2 == remainder]
    rows, known = [], {}
    for name in dict.fromkeys(walk.dataset for walk in walks):
        own, others = ([walk for walk in half if (walk.dataset == name) == here] for here in (True, False))
        labels = {"dataset": name, "asked": " ".join(str(walk.run) for walk in own), "half": HALVES[remainder]}
        verdict = score_test(total_scores(own), params.alpha, stream(params.seed, "judge", name, remainder))
        rows += rows_of(verdict, labels | {"by": NAMED})
        known[name] = {NAMED: verdict.named, SHARED: ()}
        if others:
            rng = stream(params.seed, "foot", name, remainder)
            verdict = score_test(total_scores(others), params.alpha, rng, among=[SINKAGE])
            rows += rows_of(verdict, labels | {"by": SHARED})
            known[name][SHARED] = verdict.named
    return rows, known


def main(sets, like, kind, params):
    """Return the named effects, and the ends: measured, and predicted."""
    walks = [ObservedWalk.of(files, run) for files in sets for run in files.dataset.runs]
    found, ends = [], []
    for remainder in list(HALVES)[: params.halves]:
        rows, known = names_by_half(walks, remainder, params)
        found += rows
        for walk in (one for one in walks if one.run % 2 != remainder):
            labels = {"dataset": walk.dataset, "run": walk.run}
            parts = predictions(walk, known[walk.dataset], kind, like.gait.drift_m_per_s, params)
            for name, draws in [("measured", walk.end[None]), *parts]:
                ends.append(pd.DataFrame(draws, columns=list(POSITION)).assign(by=name, **labels))
    return pd.DataFrame(found), pd.concat(ends, ignore_index=True)


with job(snakemake) as (source, params, output):
    known = catalogue.load("data", "workflow/schemas")
    sets = [RawFiles(known[name], source[name]) for name in params.sets]
    found, ends = main(sets, Walk.read(source.recipe), DeviceClass.read(source.kind), params)
    save(output, found=found, ends=ends)
