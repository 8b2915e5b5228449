"""Follow the iterations of indirect inference on one run (figure 2 of the source)."""

from imugap.estimation.gmwm.estimator import GmwmOptions, Weighting, fit, fit_by_simulation
from imugap.figures import estimation, style
from imugap.study.experiment import Experiment
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        experiment = Experiment.read(snakemake.input.recipe)
        sequence = experiment.simulate(snakemake.params.seed, "iterations")
        histories = {
            f"indirect_{weighting.value}": fit(
                sequence, experiment.interval, experiment.kinds, GmwmOptions(weighting=weighting)
            ).history
            for weighting in Weighting
        }
        histories["indirect_simulated"] = fit_by_simulation(
            sequence, experiment.interval, experiment.kinds, snakemake.params.seed
        ).history
        style.save(estimation.iterations(histories, experiment.truth()), snakemake.output[0])
