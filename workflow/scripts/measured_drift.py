"""Navigate every run of a device."""

import numpy as np

from imugap import log
from imugap.drift import Course
from imugap.journal import journal


def main(paths, site, course, path):
    """Write the drifts, shape (starts, runs, epochs, 9), and their epochs."""
    plan = Course.from_mapping(site, course)
    drifts = np.stack([plan.drift(log.load(one, columns=list(log.AXES))) for one in paths], axis=1)
    interval = log.interval(log.load(paths[0], columns=[log.AXES[0]]))
    np.savez(path, time=plan.epochs(), drift=drifts, interval=interval)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        main(snakemake.input.logs, snakemake.params.site, snakemake.params.course, snakemake.output[0])
