"""Build the error-free log of a recording from its poses, and read the biases that their publisher estimated."""

from imugap import log
from imugap.io import recording
from imugap.io.catalogue import datasets as catalogue
from imugap.io.references.poses import read_biases, read_poses
from imugap.kinematics.error_free import error_free_log_of
from imugap.units import STANDARD_GRAVITY
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    dataset = catalogue.load("data", "workflow/schemas")[params.recipe["dataset"]]
    catalogue.verify(dataset.file(params.recipe["run"], catalogue.POSES), source.poses)
    measured = recording.read(source.log).table
    log.write(error_free_log_of(measured, read_poses(source.poses), STANDARD_GRAVITY), output.reference)
    biases = read_biases(source.poses).mean()
    save(output, biases=biases.rename_axis("axis").rename("published").reset_index())
