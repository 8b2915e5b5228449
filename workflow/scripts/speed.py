"""Time the kernels against their peers and limits, in one run on one machine."""

import os
import resource
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import allantools
import numpy as np
import pandas as pd
from numba import njit

from imugap import log
from imugap.estimation import maximum_likelihood
from imugap.estimation.gmwm import estimator
from imugap.estimation.indices import INDICES, of_run
from imugap.estimation.variances import allan, wavelet_variance
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.kinematics.strapdown import Ellipsoid, Local, NavigationState, navigate
from imugap.navigation.drive.vehicle import DriveInputs
from imugap.navigation.drive.vehicle import navigate as navigate_vehicle
from imugap.navigation.drive.vehicle_alignment import align
from imugap.navigation.walk.pedestrian import WalkAssumptions
from imugap.navigation.walk.pedestrian import navigate as navigate_foot
from imugap.simulation.drive import Drive
from imugap.simulation.gnss_faults import Faults
from imugap.simulation.walk import Walk
from imugap.stream import stream
from imugap.study.drive.fault_ablation import Ablation
from imugap.study.static.experiment import Experiment
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

INTERVAL = 0.01
FIRST_WALK = """
import sys
from time import perf_counter
start = perf_counter()
from imugap.simulation.walk import Walk
from imugap.navigation.walk.pedestrian import WalkAssumptions, navigate
walk = Walk.read(sys.argv[1])
navigate(walk.record(0, 0), walk.model, WalkAssumptions(gravity=walk.site.gravity, arm_std=0.0))
print(perf_counter() - start)
"""
"""What a new process does that times its first walk."""


def median_time(work, repeats):
    """Return the median processor time of ``work`` [s] after one call that compiles."""
    work()
    times = []
    for _ in range(repeats):
        start = process_time()
        work()
        times.append(process_time() - start)
    return float(np.median(times))


def kernels(samples, repeats):
    """Time the strapdown kernel in both forms, and the Allan deviation against allantools on the same taus."""
    rng = stream(0, "speed")
    gyro, accel = 0.1 * rng.standard_normal((samples, 3)), rng.standard_normal((samples, 3)) - [0, 0, 9.8]
    device = np.concatenate([gyro, accel], axis=1)
    for name, form in {"strapdown, local": Local(9.8), "strapdown, ellipsoid": Ellipsoid(0.8, 0.0, 100.0)}.items():
        given = gyro, accel, INTERVAL, NavigationState(), form, samples - 1
        spent = median_time(lambda given=given: navigate(*given), repeats)
        yield [name, f"{samples} samples, one core", spent, "million samples/s", samples / spent / 1e6]
    averaging = allan.factors(samples)
    own = median_time(lambda: [allan.variance(axis, averaging) for axis in device.T], repeats)
    taus = averaging * INTERVAL
    peer = median_time(lambda: [allantools.oadev(a, 1 / INTERVAL, "freq", taus=taus) for a in device.T], repeats)
    what = f"{samples} × 6, {len(averaging)} averaging times, one core"
    yield ["Allan deviation, here", what, own, "times faster than allantools", peer / own]
    yield ["Allan deviation, allantools", what, peer, "", np.nan]


@njit
def plain(sequence, levels):
    """Return the Haar wavelet variance of all levels by the loop that one would write first: the limit to beat."""
    total = np.zeros(len(sequence) + 1)
    for k in range(len(sequence)):
        total[k + 1] = total[k] + sequence[k]
    result = np.zeros(levels)
    for level in range(levels):
        n = 2**level
        for k in range(len(sequence) - 2 * n + 1):
            result[level] += (total[k + 2 * n] - 2 * total[k + n] + total[k]) ** 2
        result[level] /= 4.0 * n * n * (len(sequence) - 2 * n + 1)
    return result


def wavelets(samples, repeats):
    """Time the wavelet variance of all levels against the plain loop and the octaves of allantools."""
    sequence = stream(0, "speed", "wavelet").standard_normal(samples)
    levels = wavelet_variance.depth(samples)
    own = median_time(lambda: wavelet_variance.variance(sequence), repeats)
    loop = median_time(lambda: plain(sequence, levels), repeats)
    peer = median_time(lambda: allantools.oadev(sequence, data_type="freq", taus="octave"), repeats)
    what = f"{samples} samples, {levels} levels, one core"
    return [
        ["wavelet variance, here", what, own, "of the time of the plain loop", own / loop],
        ["wavelet variance, plain compiled loop", what, loop, "", np.nan],
        ["Allan deviation in octaves, allantools", what, peer, "times the time here", peer / own],
    ]


def walks(recipe, peers, samples, repeats):
    """Time the zero-velocity detector and the filter of 15 states on a simulated walk, over and over.

    Peers were timed once, elsewhere, on a real walk: their times are those of as many samples.
    """
    walk = Walk.read(recipe)
    once = walk.record(0, 0)
    times = -(-samples // len(once))
    columns = {axis: np.tile(once[axis].to_numpy(), times)[:samples] for axis in log.AXES}
    table = log.from_samples(columns, 1 / walk.rate_hz)
    plain = WalkAssumptions(gravity=walk.site.gravity, arm_std=0.0)
    spent = median_time(lambda: navigate_foot(table, walk.model, plain), repeats)
    full = median_time(lambda: navigate_foot(table, walk.model, WalkAssumptions(gravity=walk.site.gravity)), repeats)
    what, measure = f"{samples} samples, one core", "million samples/s"
    others = [
        [f"foot-mounted filter, {one.program}", f"{one.samples} samples, elsewhere", one.seconds,
         "times the time here of a sample", one.seconds / one.samples / (spent / samples)]
        for one in pd.read_csv(peers).itertuples()
    ]  # fmt: skip
    return [
        ["detector and foot-mounted filter, 15 states", what, spent, measure, samples / spent / 1e6],
        ["detector and foot-mounted filter, 18 states", what, full, measure, samples / full / 1e6],
        *others,
    ]


def first_walks(recipe):
    """Time the first walk of a new process, imports and simulation included: nothing compiled before, and all of it."""
    command = [sys.executable, "-c", FIRST_WALK, recipe]
    with TemporaryDirectory() as folder:
        environment = os.environ | {"NUMBA_CACHE_DIR": folder}
        spent = [
            float(subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout)
            for _ in range(2)
        ]
    what = "new process, imports included"
    return [
        ["detector and foot-mounted filter, first call", f"{what}, nothing compiled before", spent[0], "", np.nan],
        ["detector and foot-mounted filter, first call", f"{what}, compiled before", spent[1], "", np.nan],
    ]


def drives(recipe, samples, repeats):
    """Time the vehicle filter of 21 states with all quality control, and its smoother, on a simulated drive in laps."""
    drive = Drive.read(recipe)
    drive = replace(drive, laps=max(1, round(samples / drive.rate_hz / drive.duration_s * drive.laps)))
    study = Ablation(drive, Faults.read(recipe))
    record, fixes = drive.record(0, 0), drive.fixes(0, 0)
    inputs = DriveInputs(record, fixes, drive.model, drive.ellipsoid, study.assumptions)
    start = align(inputs)
    what = f"{len(record)} samples, {len(fixes)} fixes, one core"
    for name, smooth in (("filter", False), ("smoother", True)):
        spent = median_time(lambda smooth=smooth: navigate_vehicle(inputs, start, smooth), repeats)
        yield [f"vehicle {name}, 21 states", what, spent, "million samples/s", len(record) / spent / 1e6]


def fits_of(experiment, method, runs):
    """Fit simulated logs, of which only the fits are timed; return the time spent [s]."""
    sequences = [experiment.simulate(0, "speed", run) for run in runs]
    method(sequences[0], experiment.interval, experiment.kinds)
    start = perf_counter()
    for sequence in sequences:
        method(sequence, experiment.interval, experiment.kinds)
    return perf_counter() - start


def fits(recipe, number):
    """Time fits of four parameters with intervals in two processes."""
    experiment = Experiment.read(recipe)
    for name, method in {"likelihood": maximum_likelihood.fit, "indirect, full weights": estimator.fit}.items():
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            halves = [range(0, number, 2), range(1, number, 2)]
            spent = max(pool.map(fits_of, [experiment] * 2, [method] * 2, halves))
        what = f"{number} logs of {experiment.count} samples, four parameters, two processes"
        yield [f"fits with intervals, {name}", what, spent, "ms per fit and process", 2e3 * spent / number]


def indices_of(path, run, period):
    """Go from one raw file to the indices of its run; return the peak memory of the process [MB]."""
    table = readers.read_raw(path, catalogue.load("data", "workflow/schemas")["adis16405"], run)
    of_run(table, pd.Series(0.0, index=list(log.AXES)), period, tuple(s for s in INDICES if s != "repeatability"))
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def chain(paths, runs, period):
    """Time the chain from raw .rda to indices, two processes at a time, imports included."""
    start = perf_counter()
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        peaks = list(pool.map(indices_of, paths, runs, [period] * len(runs)))
    spent = perf_counter() - start
    what = f"{len(runs)} runs, two processes"
    return [["raw .rda to indices", what, spent, "MB at most in a process", max(peaks)]]


# started processes import this module again
if __name__ == "__main__":
    with job(snakemake) as (source, params, output):
        sizes = params.samples, params.repeats
        rows = [*kernels(*sizes), *wavelets(*sizes), *walks(source.walk, source.walkers, *sizes)]
        rows += first_walks(source.walk) if params.first_calls else []
        rows += [*drives(source.drive, *sizes), *fits(source.recipe, params.fits)]
        rows += chain(source.raw, params.runs, params.period_s) if source.raw else []
        data = pd.DataFrame(rows, columns=["what", "task", "seconds", "measure", "value"])
        shown = {name: data[name].map(tables.number) for name in ("seconds", "value")}
        save(output, table=(data, data.assign(**shown)))
