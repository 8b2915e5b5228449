from imugap.study.farrell2022 import MODELS


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
        "results/{device}/tutorial/allan.csv",
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
        report(
            "paper/figures/tutorial_{device}.svg",
            caption="../report/tutorial.rst",
            category="Allan deviation to state space",
            labels={"result": "continuous models (figure), {device}"},
        ),
        report(
            "paper/tables/tutorial_{device}.csv",
            caption="../report/tutorial.rst",
            category="Allan deviation to state space",
            labels={"result": "where the continuous models depart (table), {device}"},
        ),
        "paper/tables/tutorial_{device}.json",
        "paper/tables/tutorial_{device}.tex",
        "paper/numbers/tutorial_{device}.json",
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
        report(
            "paper/figures/worked_example.svg",
            caption="../report/worked_example.rst",
            category="Allan deviation to state space",
            labels={"result": "worked example (figure)"},
        ),
        report(
            "paper/tables/worked_example.csv",
            caption="../report/worked_example.rst",
            category="Allan deviation to state space",
            labels={"result": "worked example (table)"},
        ),
        "paper/tables/worked_example.json",
        "paper/tables/worked_example.tex",
        "paper/numbers/worked_example.json",
    log:
        "logs/worked_example.log",
    params:
        code=library("worked_example"),
    script:
        "../scripts/worked_example.py"


rule flicker_bank:
    """Fit banks of Gauss-Markov states to flicker noise and take their errors."""
    output:
        report(
            "paper/figures/flicker_bank.svg",
            caption="../report/flicker_bank.rst",
            category="Allan deviation to state space",
            labels={"result": "flicker bank (figure)"},
        ),
        report(
            "paper/tables/flicker_bank.csv",
            caption="../report/flicker_bank.rst",
            category="Allan deviation to state space",
            labels={"result": "states and error (table)"},
        ),
        "paper/tables/flicker_bank.json",
        "paper/tables/flicker_bank.tex",
        "paper/numbers/flicker_bank.json",
    log:
        "logs/flicker_bank.log",
    params:
        code=library("flicker_bank"),
    script:
        "../scripts/flicker_bank.py"


rule false_readings:
    """Count how often each law is read on simulated logs, whether it is there or not."""
    output:
        report(
            "paper/tables/false_readings.csv",
            caption="../report/false_readings.rst",
            category="Allan deviation to state space",
            labels={"result": "readings of laws (table)"},
        ),
        "paper/tables/false_readings.json",
        "paper/tables/false_readings.tex",
        "paper/numbers/false_readings.json",
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
        report(
            "paper/tables/piecewise.csv",
            caption="../report/piecewise.rst",
            category="Allan deviation to state space",
            labels={"result": "accuracy of readings (table)"},
        ),
        "paper/tables/piecewise.json",
        "paper/tables/piecewise.tex",
        "paper/numbers/piecewise.json",
    log:
        "logs/piecewise.log",
    params:
        **config["tutorial"]["readings"],
        seed=config["seed"],
        code=library("piecewise"),
    script:
        "../scripts/piecewise.py"


PAPER["tutorial"] += of_devices(
    "paper/figures/tutorial_{device}.svg",
    "paper/tables/tutorial_{device}.json",
    "paper/numbers/tutorial_{device}.json",
)
PAPER["tutorial"] += [
    "paper/figures/worked_example.svg",
    "paper/tables/worked_example.json",
    "paper/numbers/worked_example.json",
    "paper/figures/flicker_bank.svg",
    "paper/numbers/flicker_bank.json",
    "paper/tables/false_readings.json",
    "paper/numbers/false_readings.json",
    "paper/tables/piecewise.json",
    "paper/numbers/piecewise.json",
]
