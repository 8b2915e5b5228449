from imugap.study.static.farrell2022 import MODELS


rule tutorial_models:
    """Build the tutorial's continuous models from the Allan curve of a device's first run."""
    input:
        allan=lambda wildcards: f"results/{wildcards.device}/{RUNS[wildcards.device][0]}/allan.csv",
    output:
        readings="results/{device}/tutorial/readings.csv",
        models=expand("results/{{device}}/tutorial/{textbook}.yaml", textbook=MODELS),
    log:
        "logs/tutorial_models/{device}.log",
    params:
        models=list(MODELS),
        code=library("tutorial_models"),
    script:
        "../scripts/tutorial_models.py"


rule tutorial_allan:
    """Take the Allan deviation of the continuous models: from their spectra, and of samples of their state spaces."""
    input:
        models=expand("results/{{device}}/tutorial/{textbook}.yaml", textbook=MODELS),
        log=lambda wildcards: f"results/{wildcards.device}/{RUNS[wildcards.device][0]}/log.parquet",
    output:
        allan="results/{device}/tutorial/allan.csv",
    log:
        "logs/tutorial_allan/{device}.log",
    params:
        seed=config["seed"],
        trials=config["tutorial"]["trials"],
        code=library("tutorial_allan"),
    script:
        "../scripts/tutorial_allan.py"


rule tutorial_figure:
    """Draw device, continuous models and their samples, and tabulate where and by how much the models depart."""
    input:
        device=lambda wildcards: f"results/{wildcards.device}/{RUNS[wildcards.device][0]}/allan.csv",
        readings="results/{device}/tutorial/readings.csv",
        models="results/{device}/tutorial/allan.csv",
    output:
        figure=figure("tutorial_{device}", "Allan deviation to state space", "continuous models (figure), {device}"),
        table=table(
            "tutorial_{device}",
            "Allan deviation to state space",
            "where the continuous models depart (table), {device}",
        ),
        numbers="paper/numbers/tutorial_{device}.json",
    log:
        "logs/tutorial_figure/{device}.log",
    params:
        code=library("tutorial_figure"),
    script:
        "../scripts/tutorial_figure.py"


rule worked_example:
    """Recompute the printed values of the tutorial's worked example from one another."""
    input:
        printed="data/published/farrell2022_worked_example.csv",
    output:
        figure=figure("worked_example", "Allan deviation to state space", "worked example (figure)"),
        table=table("worked_example", "Allan deviation to state space", "worked example (table)"),
        numbers="paper/numbers/worked_example.json",
    log:
        "logs/worked_example.log",
    params:
        code=library("worked_example"),
    script:
        "../scripts/worked_example.py"


rule flicker_bank:
    """Fit banks of Gauss-Markov states to flicker noise and take their errors."""
    output:
        figure=figure("flicker_bank", "Allan deviation to state space", "flicker bank (figure)"),
        table=table("flicker_bank", "Allan deviation to state space", "states and error (table)"),
        numbers="paper/numbers/flicker_bank.json",
    log:
        "logs/flicker_bank.log",
    params:
        code=library("flicker_bank"),
    script:
        "../scripts/flicker_bank.py"


rule false_readings:
    """Count how often each law is read on simulated logs, whether it is there or not."""
    output:
        table=table("false_readings", "Allan deviation to state space", "readings of laws (table)"),
        numbers="paper/numbers/false_readings.json",
    log:
        "logs/false_readings.log",
    params:
        **config["tutorial"]["readings"],
        seed=config["seed"],
        code=library("false_readings"),
    script:
        "../scripts/false_readings.py"


rule piecewise:
    """Score the classical reading of white noise and a Gauss-Markov process on simulated logs."""
    output:
        table=table("piecewise", "Allan deviation to state space", "accuracy of readings (table)"),
        numbers="paper/numbers/piecewise.json",
    log:
        "logs/piecewise.log",
    params:
        **config["tutorial"]["readings"],
        seed=config["seed"],
        code=library("piecewise"),
    script:
        "../scripts/piecewise.py"


PAPER["tutorial"] += of_devices(rules.tutorial_figure)
for one in (rules.worked_example, rules.flicker_bank, rules.false_readings, rules.piecewise):
    PAPER["tutorial"] += one.output
