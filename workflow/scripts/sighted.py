"""Cut the motion of every trial, and the error-free log that the cameras give of it, to the same band."""

import pandas as pd

from imugap import log
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.io.references import motion_capture as optical
from imugap.io.references import reference
from imugap.kinematics.site import Site
from imugap.workflow.job_log import job


def main(run, dataset, params, raw, log_path, reference_path, cut_path, ideal_path, noise_path):
    """Write log and error-free log of the motion of a trial, and the noise of the latter."""
    catalogue.verify(dataset.file(run), raw)
    table, known = log.load(log_path), pd.read_parquet(reference_path)
    track = optical.track_of(known, readers.read_positions(raw, dataset, run))
    alignment = optical.aligned(table, track, known, Site.from_mapping(params.site).gravity)
    pair = optical.band_limited(table, track, alignment, params.bandwidth_hz)
    begin, end = reference.motion(known)
    log.write(pair.log.loc[begin:end], cut_path)
    log.write(pair.ideal.loc[begin:end], ideal_path)
    still = pair.ideal.loc[: begin - params.margin_s].std()
    unseen = pair.unseen[(pair.log.index >= begin) & (pair.log.index <= end)].mean()
    still.rename_axis("axis").rename("std").to_frame().assign(unseen=unseen).to_csv(noise_path)


with job(snakemake) as (source, params, output):
    broad = catalogue.load("data", "workflow/schemas")["broad"]
    paths = source.raw, source.logs, source.references, output.logs, output.ideals, output.noises
    for run, *files in zip(params.trials, *paths, strict=True):
        main(run, broad, params, *files)
