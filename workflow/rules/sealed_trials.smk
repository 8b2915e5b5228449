# Sealed cases of few axes: how sure a name is, and what a search loses against the test that knows what it looks for.
localrules:
    trials_joined,
    trials_page,


rule sealed_trials:
    """Seal a batch of cases, and discover on the axes of each that hide something."""
    input:
        recipe="benchmark/src/imu_benchmark/recipe.toml",
    output:
        forecasts="results/trials/{trial}/{batch}_forecasts.csv",
        curves="results/trials/{trial}/{batch}_curves.csv",
    log:
        "logs/sealed_trials/{trial}_{batch}.log",
    wildcard_constraints:
        trial="forecasts|curves",
        batch=r"\d+",
    resources:
        mem_mb=2000,
        runtime=60,
    params:
        trial=lambda wildcards: config["trials"][wildcards.trial],
        ranges=config["trials"]["ranges"],
        cases=config["trials"]["cases_per_job"],
        settings=DISCOVERY_SETTINGS,
        seed=config["seed"],
        code=library("sealed_trials"),
    script:
        "../scripts/sealed_trials.py"


rule trials_joined:
    """Join the batches of a trial."""
    input:
        lambda wildcards: expand("results/trials/{{trial}}/{batch}_{{trial}}.csv", batch=trial_batches(wildcards.trial)),
    output:
        "results/trials/{trial}.csv",
    log:
        "logs/trials_joined/{trial}.log",
    wildcard_constraints:
        trial="forecasts|curves",
    script:
        "../scripts/joined.py"


rule trials_page:
    """Draw and tabulate how sure the names are, and the loss of the search, of a run here or of the recorded one."""
    input:
        unpack(trial_tables),
    output:
        reliability_figure=figure("{trials}_reliability", "Discovery", "reliability (figure)", caption="trials"),
        curves_figure=figure("{trials}_curves", "Discovery", "loss of the search (figure)", caption="trials"),
        reliability=table("{trials}_reliability", "Discovery", "reliability (table)", caption="trials"),
        losses=table("{trials}_losses", "Discovery", "loss of the search (table)", caption="trials"),
        numbers="paper/numbers/{trials}.json",
    log:
        "logs/{trials}_page.log",
    wildcard_constraints:
        trials="trials|trials_recorded",
    params:
        code=library("trials_page"),
    script:
        "../scripts/trials_page.py"


PAPER["discovery"] += ["paper/numbers/trials_recorded.json"] if config["trials"]["recorded"] else []


rule ablation:
    """Compare the held-out gain of names with that of wrong names, on sealed cases and on further runs of devices."""
    input:
        recipe="benchmark/src/imu_benchmark/recipe.toml",
        logs=[path for device in UNSEEN_OF for path in per_run(device, "means.parquet")],
    output:
        comparisons="results/ablation/comparisons.csv",
    log:
        "logs/ablation.log",
    resources:
        mem_mb=3000,
        runtime=120,
    params:
        devices=UNSEEN_OF,
        cases=config["trials"]["ablation"]["cases"],
        cases_seed=config["trials"]["ablation"]["seed"],
        ranges=config["trials"]["ranges"] | {"sizes": [10, 30]},
        settings=DISCOVERY_SETTINGS,
        seed=config["seed"],
        code=library("ablation"),
    script:
        "../scripts/ablation.py"


rule ablation_page:
    """Tabulate how much of the held-out gain of a name a wrong name has, of a run here or of the recorded one."""
    input:
        unpack(ablation_tables),
    output:
        table=table("{ablation}", "Discovery", "names and wrong names (table)", caption="ablation"),
        numbers="paper/numbers/{ablation}.json",
    log:
        "logs/{ablation}_page.log",
    wildcard_constraints:
        ablation="ablation|ablation_recorded",
    params:
        code=library("ablation_page"),
    script:
        "../scripts/ablation_page.py"


rule injection:
    """Add known effects to the real logs of devices, and see whether discovery names them with their sizes."""
    input:
        logs=[path for device in UNSEEN_OF for path in per_run(device, "means.parquet")],
    output:
        trials="results/injection/trials.csv",
    log:
        "logs/injection.log",
    threads: 2
    resources:
        mem_mb=3000,
        runtime=120,
    params:
        runs=[(device, run) for device in UNSEEN_OF for run in RUNS[device]],
        sizes=config["injection"]["sizes"],
        together=config["injection"]["together"],
        settings=DISCOVERY_SETTINGS,
        seed=config["seed"],
        code=library("injection"),
    script:
        "../scripts/injection.py"


rule injection_page:
    """Tabulate how often injected effects are named, and how right their sizes are, here or in the recorded run."""
    input:
        unpack(injection_tables),
    output:
        table=table("{injection}", "Discovery", "injected effects (table)", caption="injection"),
        numbers="paper/numbers/{injection}.json",
    log:
        "logs/{injection}_page.log",
    wildcard_constraints:
        injection="injection|injection_recorded",
    params:
        code=library("injection_page"),
    script:
        "../scripts/injection_page.py"


RECORDED_NAMES = ["paper/numbers/ablation_recorded.json", "paper/numbers/injection_recorded.json"]
PAPER["discovery"] += RECORDED_NAMES if config["trials"]["recorded"] else []
