"""Follow the iterations of indirect inference on one run (figure 2 of the source)."""

from imugap.estimation.gmwm.estimator import GmwmOptions, Weighting, fit, fit_by_simulation
from imugap.figures import estimation
from imugap.study.static.experiment import Experiment
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    experiment = Experiment.read(source.recipe)
    log = experiment.simulate(params.seed, "iterations"), experiment.interval, experiment.kinds
    histories = {f"indirect_{one.value}": fit(*log, GmwmOptions(weighting=one)).history for one in Weighting}
    histories["indirect_simulated"] = fit_by_simulation(*log, params.seed).history
    save(output, figure=estimation.iterations(histories, experiment.truth()))
