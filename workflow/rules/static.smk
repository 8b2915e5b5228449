for device in DEVICES:

    rule:
        """Estimate the performance indices and the Allan deviation of every run of a device."""
        name:
            f"indices_{device}"
        input:
            logs=per_run(device, "log.parquet"),
        output:
            indices=per_run(device, "indices.csv"),
            allan=per_run(device, "allan.csv"),
        log:
            f"logs/indices/{device}.log",
        priority: 1
        params:
            site=SITES[device],
            period_s=config["bias_stability_period_s"],
            code=library("indices"),
        script:
            "../scripts/indices.py"


rule device_indices:
    """Combine the indices and the Allan curves of all runs of a device."""
    input:
        indices=of_runs("indices.csv"),
        allan=of_runs("allan.csv"),
    output:
        runs="results/{device}/indices_runs.csv",
        indices="results/{device}/indices.csv",
        allan="results/{device}/allan.csv",
    log:
        "logs/device_indices/{device}.log",
    priority: 1
    params:
        runs=lambda wildcards: RUNS[wildcards.device],
        code=library("device_indices"),
    script:
        "../scripts/device_indices.py"


rule indices_table:
    """Tabulate the performance indices of a device in data-sheet units, SI beside."""
    input:
        indices="results/{device}/indices.csv",
    output:
        table=table("indices_{device}", "Performance indices", "indices (table), {device}"),
        numbers="paper/numbers/indices_{device}.json",
    log:
        "logs/indices_table/{device}.log",
    params:
        code=library("indices_table"),
    script:
        "../scripts/indices_table.py"


rule allan_figure:
    """Draw the Allan deviation of six axes with bands and the tangents that were read."""
    input:
        allan="results/{device}/allan.csv",
        indices="results/{device}/indices_runs.csv",
    output:
        figure=figure("allan_{device}", "Performance indices", "Allan deviation (figure), {device}"),
    log:
        "logs/allan_figure/{device}.log",
    params:
        code=library("allan_figure"),
    script:
        "../scripts/allan_figure.py"


rule bench_score:
    """Compare the indices of the virtual bench with its truth."""
    input:
        indices="results/bench/indices.csv",
        truth="results/bench/truth.json",
    output:
        table=table("bench_score", "Performance indices", "indices against truth (table), bench"),
        numbers="paper/numbers/bench_score.json",
    log:
        "logs/bench_score.log",
    params:
        rate_hz=config["bench"]["rate_hz"],
        code=library("bench_score"),
    script:
        "../scripts/bench_score.py"


rule clock:
    """Measure the sampling interval of every run relative to the first, and what it does to the indices."""
    input:
        logs=of_runs("log.parquet"),
        indices="results/{device}/indices_runs.csv",
    output:
        figure=figure("clock_{device}", "Data", "sampling clock (figure), {device}"),
        table=table("clock_{device}", "Data", "sampling clock (table), {device}"),
        numbers="paper/numbers/clock_{device}.json",
    log:
        "logs/clock/{device}.log",
    params:
        runs=lambda wildcards: RUNS[wildcards.device],
        code=library("clock"),
    script:
        "../scripts/clock.py"


rule turn_on:
    """Compare the scatter of the bias over power cycles with what noise within a cycle explains."""
    input:
        logs=expand("results/memsense_turnon/{run}/log.parquet", run=POWER_CYCLES),
    output:
        figure=figure("turn_on", "Performance indices", "turn-on bias (figure), memsense_turnon"),
        table=table("turn_on", "Performance indices", "turn-on bias (table), memsense_turnon"),
    log:
        "logs/turn_on.log",
    params:
        runs=POWER_CYCLES,
        period_s=config["bias_stability_period_s"],
        code=library("turn_on"),
    script:
        "../scripts/turn_on.py"


PAPER["study"] += [*of_devices(rules.allan_figure), *of_devices(rules.indices_table)]
PAPER["study"] += expand(rules.clock.output, device=[device for device in DEVICES if len(RUNS[device]) > 1])
PAPER["study"] += rules.bench_score.output if "bench" in DEVICES else []
PAPER["study"] += rules.turn_on.output if POWER_CYCLES else []
