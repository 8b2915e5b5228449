# The contenders with noise, whose Allan deviation is taken.
SPREAD = [name for name in CONTENDERS if name != "bias_only"]


rule fit_models:
    """Build every contender from the indices of a device."""
    input:
        indices="results/{device}/indices.csv",
        allan="results/{device}/allan.csv",
    output:
        expand("results/{{device}}/models/{contender}.yaml", contender=CONTENDERS),
    log:
        "logs/fit_models/{device}.log",
    priority: 1
    params:
        contenders=list(CONTENDERS),
        period_s=config["bias_stability_period_s"],
        code=library("fit_models"),
    script:
        "../scripts/fit_models.py"


rule model_allan:
    """Simulate every contender over the length of the device's runs and take the Allan deviation of each trial."""
    input:
        models=expand("results/{{device}}/models/{contender}.yaml", contender=SPREAD),
        log=lambda wildcards: f"results/{wildcards.device}/{RUNS[wildcards.device][0]}/log.parquet",
    output:
        expand("results/{{device}}/model_allan/{contender}.csv", contender=SPREAD),
    log:
        "logs/model_allan/{device}.log",
    params:
        contenders=SPREAD,
        seed=config["seed"],
        trials=config["allan_trials"],
        code=library("model_allan"),
    script:
        "../scripts/model_allan.py"


rule models_figure:
    """Draw the Allan deviation of every contender against the device, and tabulate where they part."""
    input:
        device="results/{device}/allan.csv",
        indices="results/{device}/indices.csv",
        models=expand("results/{{device}}/model_allan/{contender}.csv", contender=SPREAD),
    output:
        figure=figure("models_{device}", "Error models", "Allan deviation of the models (figure), {device}"),
        table=table("models_{device}", "Error models", "where models and device part (table), {device}"),
        numbers="paper/numbers/models_{device}.json",
    log:
        "logs/models_figure/{device}.log",
    params:
        code=library("models_figure"),
    script:
        "../scripts/models_figure.py"


PAPER["study"] += of_devices(rules.models_figure)
