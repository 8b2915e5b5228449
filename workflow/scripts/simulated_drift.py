"""Simulate every contender at rest and navigate every trial."""

import numpy as np

from imugap.kinematics.free_inertial import QUANTITIES, StaticNavigation
from imugap.model import ErrorModel
from imugap.workflow.job_log import journal


def main(model_path, measured, contender, params, path):
    """Write the drifts of the compared quantities, shape (starts, trials, epochs, quantities), and their epochs."""
    like = np.load(measured)
    model, plan = (
        ErrorModel.read(model_path),
        StaticNavigation.from_mapping(params.site, params.course, float(like["time"][-1])),
    )
    ideal = plan.ideal(float(like["interval"]))
    columns = list(QUANTITIES.values())
    drifts = np.stack(
        [
            plan.drift(model.simulate(ideal, params.seed, "drift", contender, trial))[..., columns]
            for trial in range(params.trials)
        ],
        axis=1,
    )
    np.savez(path, time=plan.epochs(), drift=drifts)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, params = snakemake.input, snakemake.params
        for contender, model, path in zip(params.contenders, source.models, snakemake.output, strict=True):
            main(model, source.measured, contender, params, path)
