"""Check the published tables."""

import pandas as pd

from imugap import tables
from imugap.audit import findings
from imugap.journal import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source = snakemake.input
        data = findings(*map(pd.read_csv, (source.indices, source.static, source.walk)))
        shown = data.assign(consistent=data["consistent"].map({True: "yes", False: "NO"}))
        tables.write(snakemake.output[0].removesuffix(".csv"), data, shown)
