rule fetch:
    """Get the raw logs of the catalogue: from the mirror if one is named, else by download."""
    log:
        "logs/fetch.log",
    params:
        mirror=MIRROR,
        folder=RAW,
    script:
        "../scripts/fetch.py"


if RUNS["bench"]:

    rule bench_logs:
        """Generate the raw logs of the static runs of the virtual bench."""
        input:
            recipe="data/bench.yaml",
        output:
            expand("data/raw/bench/run{run}.parquet", run=RUNS["bench"]),
        log:
            "logs/bench_logs.log",
        priority: 1
        params:
            runs=RUNS["bench"],
            seed=config["seed"],
            duration_s=config["bench"]["duration_s"],
            rate_hz=config["bench"]["rate_hz"],
            code=library("bench_logs"),
        script:
            "../scripts/bench_logs.py"


rule bench_truth:
    """Write the truth of the virtual bench, which only scoring reads."""
    input:
        recipe="data/bench.yaml",
    output:
        truth="results/bench/truth.json",
    log:
        "logs/bench_truth.log",
    params:
        code=library("bench_truth"),
    script:
        "../scripts/bench_truth.py"


for device, runs in LOGS.items():

    rule:
        """Turn the raw logs of a device into canonical logs, with a report on the integrity of each."""
        name:
            f"ingest_{device}"
        input:
            raw=[] if device == "own" else raw_logs(device),
            tables=["data/datasets.csv", "data/files.csv"],
        output:
            logs=per_run(device, "log.parquet"),
            integrity=per_run(device, "integrity.json"),
        log:
            f"logs/ingest/{device}.log",
        priority: 1
        params:
            device=device,
            runs=runs,
            raw=lambda wildcards, paths=raw_logs(device): paths,
            states=states(OWN_FILES["own_logs"]) if device == "own" else [],
            period_s=config["bias_stability_period_s"],
            code=library("ingest"),
        script:
            "../scripts/ingest.py"


rule integrity_table:
    """Collect the integrity reports of a device."""
    input:
        reports=of_runs("integrity.json"),
    output:
        table=table("integrity_{device}", "Data", "integrity (table), {device}"),
        numbers="paper/numbers/integrity_{device}.json",
    log:
        "logs/integrity_table/{device}.log",
    params:
        runs=lambda wildcards: RUNS[wildcards.device],
        code=library("integrity_table"),
    script:
        "../scripts/integrity_table.py"


PAPER["study"] += of_devices(rules.integrity_table)
