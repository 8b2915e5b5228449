"""Simulate the log of a device at rest whose error model has an effect of one's own."""

import numpy as np

from imugap import log
from imugap.interchange.plugins import catalogue
from imugap.model import ErrorModel
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    model = ErrorModel.read(source.model, catalogue(params.effects))
    silent = dict.fromkeys(model.sensors, np.zeros(round(params.duration_s * params.rate_hz)))
    still = log.from_samples(silent, 1 / params.rate_hz)
    log.write(model.simulate(still, params.seed, "story", "heater"), output[0])
