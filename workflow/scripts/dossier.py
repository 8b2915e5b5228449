"""Discover on the log of a user and leave the folder of what was found."""

from pathlib import Path

from imugap.api.discoveries import Discovered
from imugap.discovery.device import Settings
from imugap.discovery.inputs import Files
from imugap.workflow.job_log import job

# started processes import this module again
if __name__ == "__main__":
    with job(snakemake) as (_, params, output):
        given = {option: tuple(map(Path, paths)) for option, paths in params.files.items()}
        single = {name: Path(*given[name]) for name in ("reference", "model") if given[name]}
        files = Files(given["log"], given["test"], **single, effects=params.effects)
        settings = Settings(**params.settings, seed=params.seed, workers=snakemake.threads)
        out = Path(output[0]).parent
        found = Discovered.of(files, settings, lambda step, done, steps: print(f"{done}/{steps} {step}"))
        found.report(out)
        print(found)
