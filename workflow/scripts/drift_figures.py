"""Draw the measured drift and its distance from the simulated drifts of one run."""

import numpy as np

from imugap.figures import static, style
from imugap.kinematics.free_inertial import QUANTITIES, STARTS, differences
from imugap.workflow.job_log import journal


def main(measured_path, simulated_paths, params, output):
    """Draw up to ``params.length_s``, the length of the published table."""
    measured = np.load(measured_path)
    shown = measured["time"] <= params.length_s
    time, drift = measured["time"][shown], measured["drift"][:, :, shown]
    style.save(static.drift(time, dict(zip(STARTS, drift, strict=True))), output.drift)
    ensembles = {
        name: np.load(path)["drift"][:, :, shown] for name, path in zip(params.contenders, simulated_paths, strict=True)
    }
    columns = list(QUANTITIES.values())
    for k, start in enumerate(STARTS):
        gaps = {name: differences(drift[k, :1][..., columns], one[k])[0] for name, one in ensembles.items()}
        style.save(static.differences(time, gaps, params.drawn), output[start])


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        main(snakemake.input.measured, snakemake.input.simulated, snakemake.params, snakemake.output)
