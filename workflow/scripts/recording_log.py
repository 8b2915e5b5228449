"""Read a recording as the file of a user, cut it to its stretch, and say what is wrong with it."""

from imugap import log
from imugap.io.catalogue import datasets as catalogue
from imugap.study.discovery.recordings import RecordingRecipe, properties
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    recipe = RecordingRecipe.from_mapping(params.recipe)
    catalogue.verify(catalogue.load("data", "workflow/schemas")[recipe.dataset].file(recipe.run), source.raw)
    found = recipe.read(source.raw)
    log.write(found.table, output.log)
    save(output, properties=properties(found))
