"""Cut the motion of a trial, and the error-free log that the cameras give of it, to the same band."""

import pandas as pd

from imugap import log
from imugap.io import datasets as catalogue
from imugap.io import motion_capture as optical
from imugap.io import readers, reference
from imugap.kinematics.site import Site
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, output, params = snakemake.input, snakemake.output, snakemake.params
        broad, run = catalogue.load("data", "workflow/schemas")["broad"], int(snakemake.wildcards.run)
        catalogue.verify(broad.file(run), source.raw)
        table, known = log.load(source.log), pd.read_parquet(source.reference)
        track = optical.track_of(known, readers.read_positions(source.raw, broad, run))
        alignment = optical.aligned(table, track, known, Site.from_mapping(params.site).gravity)
        pair = optical.band_limited(table, track, alignment, params.bandwidth_hz)
        begin, end = reference.motion(known)
        log.write(pair.log.loc[begin:end], output.log)
        log.write(pair.ideal.loc[begin:end], output.ideal)
        still = pair.ideal.loc[: begin - params.margin_s].std()
        unseen = pair.unseen[(pair.log.index >= begin) & (pair.log.index <= end)].mean()
        still.rename_axis("axis").rename("std").to_frame().assign(unseen=unseen).to_csv(output.noise)
