"""Check the published tables."""

import pandas as pd

from imugap.study.he2023 import findings
from imugap.workflow import tables
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source = snakemake.input
        data = findings(*map(pd.read_csv, (source.indices, source.static, source.walk)))
        shown = data.assign(consistent=data["consistent"].map({True: "yes", False: "NO"}))
        tables.write(snakemake.output[0].removesuffix(".csv"), data, shown)
