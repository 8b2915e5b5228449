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
        report(
            "paper/tables/indices_{device}.csv",
            caption="../report/indices.rst",
            category="Performance indices",
            labels={"result": "indices (table), {device}"},
        ),
        "paper/tables/indices_{device}.json",
        "paper/tables/indices_{device}.tex",
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
        report(
            "paper/figures/allan_{device}.svg",
            caption="../report/allan.rst",
            category="Performance indices",
            labels={"result": "Allan deviation (figure), {device}"},
        ),
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
        report(
            "paper/tables/bench_score.csv",
            caption="../report/bench_score.rst",
            category="Performance indices",
            labels={"result": "indices against truth (table), bench"},
        ),
        "paper/tables/bench_score.json",
        "paper/tables/bench_score.tex",
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
        report(
            "paper/figures/clock_{device}.svg",
            caption="../report/clock.rst",
            category="Data",
            labels={"result": "sampling clock (figure), {device}"},
        ),
        report(
            "paper/tables/clock_{device}.csv",
            caption="../report/clock.rst",
            category="Data",
            labels={"result": "sampling clock (table), {device}"},
        ),
        "paper/tables/clock_{device}.json",
        "paper/tables/clock_{device}.tex",
        "paper/numbers/clock_{device}.json",
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
        report(
            "paper/figures/turn_on.svg",
            caption="../report/turn_on.rst",
            category="Performance indices",
            labels={"result": "turn-on bias (figure), memsense_turnon"},
        ),
        report(
            "paper/tables/turn_on.csv",
            caption="../report/turn_on.rst",
            category="Performance indices",
            labels={"result": "turn-on bias (table), memsense_turnon"},
        ),
        "paper/tables/turn_on.json",
        "paper/tables/turn_on.tex",
    log:
        "logs/turn_on.log",
    params:
        runs=POWER_CYCLES,
        period_s=config["bias_stability_period_s"],
        code=library("turn_on"),
    script:
        "../scripts/turn_on.py"


PAPER["study"] += of_devices(
    "paper/figures/allan_{device}.svg",
    "paper/tables/indices_{device}.json",
)
PAPER["study"] += [
    f"paper/numbers/clock_{device}.json" for device in DEVICES if len(RUNS[device]) > 1
]
PAPER["study"] += (
    ["paper/tables/bench_score.json", "paper/numbers/bench_score.json"]
    if "bench" in DEVICES
    else []
)
PAPER["study"] += ["paper/tables/turn_on.json"] if POWER_CYCLES else []
