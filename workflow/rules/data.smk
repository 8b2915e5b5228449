rule fetch:
    """Get the raw logs of the catalogue: from the mirror if one is named, else by download."""
    log:
        "logs/fetch.log",
    params:
        mirror=MIRROR,
        folder=RAW,
    script:
        "../scripts/fetch.py"


rule bench_log:
    """Generate the raw log of one static run of the virtual bench."""
    input:
        recipe="data/bench.yaml",
    output:
        "data/raw/bench/run{run}.parquet",
    log:
        "logs/bench_log/{run}.log",
    benchmark:
        "benchmarks/bench_log/{run}.tsv"
    params:
        seed=config["seed"],
        duration_s=config["bench"]["duration_s"],
        rate_hz=config["bench"]["rate_hz"],
        code=library("bench_log"),
    script:
        "../scripts/bench_log.py"


rule bench_truth:
    """Write the truth of the virtual bench, which only scoring reads."""
    input:
        recipe="data/bench.yaml",
    output:
        "results/bench/truth.json",
    log:
        "logs/bench_truth.log",
    benchmark:
        "benchmarks/bench_truth.tsv"
    params:
        code=library("bench_truth"),
    script:
        "../scripts/bench_truth.py"


rule ingest:
    """Turn a raw log into a canonical log, with a report on its integrity."""
    input:
        raw=raw_log,
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        log="results/{device}/{run}/log.parquet",
        integrity="results/{device}/{run}/integrity.json",
    log:
        "logs/ingest/{device}_{run}.log",
    benchmark:
        "benchmarks/ingest/{device}_{run}.tsv"
    params:
        code=library("ingest"),
    script:
        "../scripts/ingest.py"


rule integrity_table:
    """Collect the integrity reports of a device."""
    input:
        reports=of_runs("integrity.json"),
    output:
        report(
            "paper/tables/integrity_{device}.csv",
            caption="../report/integrity.rst",
            category="Data",
            labels={"result": "integrity (table), {device}"},
        ),
        "paper/tables/integrity_{device}.json",
        "paper/tables/integrity_{device}.tex",
    log:
        "logs/integrity_table/{device}.log",
    benchmark:
        "benchmarks/integrity_table/{device}.tsv"
    params:
        runs=lambda wildcards: RUNS[wildcards.device],
        code=library("integrity_table"),
    script:
        "../scripts/integrity_table.py"


PAPER["study"] += of_devices("paper/tables/integrity_{device}.json")
