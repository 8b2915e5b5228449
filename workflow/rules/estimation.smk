TIMES = config["estimation"]["correlation_times_s"]


rule monte_carlo:
    """Simulate the source's device many times and estimate its parameters by every method."""
    input:
        recipe="data/indirect.yaml",
    output:
        estimates="results/indirect/monte_carlo_{time}.parquet",
    log:
        "logs/monte_carlo/{time}.log",
    wildcard_constraints:
        time=r"\d+",
    params:
        seed=config["seed"],
        runs=config["estimation"]["runs"],
        printed=config["estimation"]["printed_runs"],
        code=library("monte_carlo"),
    script:
        "../scripts/monte_carlo.py"


rule monte_carlo_tables:
    """Tabulate five runs as the source does, and beside them what many runs say of every method."""
    input:
        recipe="data/indirect.yaml",
        published="data/published/liu2016_results.csv",
        estimates=expand("results/indirect/monte_carlo_{time}.parquet", time=TIMES),
    output:
        five=table("indirect_five_runs", "Estimation", "five runs (table)"),
        summary=table("monte_carlo", "Estimation", "bias, error, coverage (table)"),
        figure=figure("monte_carlo", "Estimation", "distribution of the correlation time (figure)"),
        numbers="paper/numbers/monte_carlo.json",
    log:
        "logs/monte_carlo_tables.log",
    params:
        times=TIMES,
        printed=config["estimation"]["printed_runs"],
        seed=config["seed"],
        code=library("monte_carlo_tables"),
    script:
        "../scripts/monte_carlo_tables.py"


rule iterations:
    """Follow the iterations of indirect inference on one run (figure 2 of the source)."""
    input:
        recipe="data/indirect.yaml",
    output:
        figure=figure("iterations", "Estimation", "iterations (figure)"),
    log:
        "logs/iterations.log",
    params:
        seed=config["seed"],
        code=library("iterations"),
    script:
        "../scripts/iterations.py"


rule bounds:
    """Tabulate the Cramer-Rao bound of every parameter for models and lengths of log."""
    input:
        recipe="data/indirect.yaml",
    output:
        figure=figure("bounds", "Estimation", "Cramer-Rao bound (figure)"),
        table=table("bounds", "Estimation", "Cramer-Rao bound (table)"),
    log:
        "logs/bounds.log",
    params:
        times=TIMES,
        lengths_s=config["estimation"]["lengths_s"],
        code=library("bounds"),
    script:
        "../scripts/bounds.py"


rule contamination:
    """Estimate from logs with gross outliers, by plain and by robust wavelet variances."""
    input:
        recipe="data/indirect.yaml",
    output:
        figure=figure("contamination", "Estimation", "contamination (figure)"),
        table=table("contamination", "Estimation", "contamination (table)"),
        numbers="paper/numbers/contamination.json",
    log:
        "logs/contamination.log",
    params:
        seed=config["seed"],
        contamination=config["estimation"]["contamination"],
        code=library("contamination"),
    script:
        "../scripts/contamination.py"


for device in DEVICES:

    rule:
        """Estimate the source's models of gyroscopes and accelerometers from every run of a device, by every method."""
        name:
            f"estimates_{device}"
        input:
            logs=per_run(device, "log.parquet"),
        output:
            per_run(device, "estimates.csv"),
        log:
            f"logs/estimates/{device}.log",
        params:
            rate_hz=config["estimation"]["rate_hz"],
            code=library("estimates"),
        script:
            "../scripts/estimates.py"


rule estimates_tables:
    """Tabulate the estimates of a device over its runs (tables 3 and 4 of the source)."""
    input:
        estimates=of_runs("estimates.csv"),
    output:
        gyro=table("estimates_gyro_{device}", "Estimation", "gyroscopes (table), {device}", caption="estimates"),
        accel=table("estimates_accel_{device}", "Estimation", "accelerometers (table), {device}", caption="estimates"),
        numbers="paper/numbers/estimates_{device}.json",
    log:
        "logs/estimates_tables/{device}.log",
    params:
        runs=lambda wildcards: RUNS[wildcards.device],
        code=library("estimates_tables"),
    script:
        "../scripts/estimates_tables.py"


rule choice:
    """Choose the effects of every axis of a device from one run, and say where the best model fails."""
    input:
        log="results/{device}/{run}/log.parquet",
    output:
        choice="results/{device}/{run}/choice.json",
        goodness="results/{device}/{run}/goodness.csv",
    log:
        "logs/choice/{device}_{run}.log",
    params:
        code=library("choice"),
    script:
        "../scripts/choice.py"


rule choice_table:
    """Tabulate the effects chosen for every axis of a device, and draw where the models fail."""
    input:
        choice=lambda wildcards: f"results/{wildcards.device}/{RUNS[wildcards.device][0]}/choice.json",
        goodness=lambda wildcards: f"results/{wildcards.device}/{RUNS[wildcards.device][0]}/goodness.csv",
    output:
        figure=figure("goodness_{device}", "Estimation", "goodness of fit (figure), {device}"),
        table=table("choice_{device}", "Estimation", "chosen effects (table), {device}"),
        numbers="paper/numbers/choice_{device}.json",
    log:
        "logs/choice_table/{device}.log",
    params:
        code=library("choice_table"),
    script:
        "../scripts/choice_table.py"


rule peers:
    """Fit the models that gmwm was run with, by its own objective: what is reached, and how fast."""
    input:
        log="results/adis16405/1/log.parquet",
        peer="data/published/gmwm_objective.csv",
    output:
        table=table("peers", "Estimation", "against gmwm (table)"),
        numbers="paper/numbers/peers.json",
    log:
        "logs/peers.log",
    params:
        code=library("peers"),
    script:
        "../scripts/peers.py"


PAPER["estimation"] += [*of_devices(rules.estimates_tables), *of_devices(rules.choice_table)]
for one in (rules.monte_carlo_tables, rules.iterations, rules.bounds, rules.contamination):
    PAPER["estimation"] += one.output
PAPER["estimation"] += rules.peers.output if "adis16405" in DEVICES else []
