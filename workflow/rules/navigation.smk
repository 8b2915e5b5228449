COURSE = {
    key: config["navigation"][key]
    for key in (
        "mechanisation",
        "calibration_s",
        "horizons_s",
        "table_horizon_s",
        "epoch_s",
    )
}
CONTROLS = ("bias_only", "white_turn_on")
DRAWN = [name for name in CONTENDERS if name not in CONTROLS]


rule measured_drift:
    """Navigate every run of a device without aid."""
    input:
        logs=of_runs("log.parquet"),
    output:
        "results/{device}/drift/measured.npz",
    log:
        "logs/measured_drift/{device}.log",
    priority: 1
    params:
        site=site,
        course=COURSE,
        code=library("measured_drift"),
    script:
        "../scripts/measured_drift.py"


rule simulated_drift:
    """Simulate every contender at rest many times and navigate every trial without aid."""
    input:
        models=expand("results/{{device}}/models/{contender}.yaml", contender=CONTENDERS),
        measured="results/{device}/drift/measured.npz",
    output:
        expand("results/{{device}}/drift/{contender}.npz", contender=CONTENDERS),
    log:
        "logs/simulated_drift/{device}.log",
    priority: 1
    params:
        contenders=list(CONTENDERS),
        site=site,
        course=COURSE,
        seed=config["seed"],
        trials=config["navigation"]["trials"],
        code=library("simulated_drift"),
    script:
        "../scripts/simulated_drift.py"


rule drift_scores:
    """Score the simulated drifts of every contender against the measured ones at every navigation length."""
    input:
        measured="results/{device}/drift/measured.npz",
        simulated=expand("results/{{device}}/drift/{contender}.npz", contender=CONTENDERS),
    output:
        errors="results/{device}/drift_errors.parquet",
        proper="results/{device}/drift_crps.parquet",
        scores="results/{device}/drift_scores.csv",
    log:
        "logs/drift_scores/{device}.log",
    params:
        contenders=list(CONTENDERS),
        horizons_s=config["navigation"]["horizons_s"],
        code=library("drift_scores"),
    script:
        "../scripts/drift_scores.py"


rule drift_figures:
    """Draw the measured drift (figure 2 of the source) and its distance from the simulated drifts (figure 3)."""
    input:
        measured="results/{device}/drift/measured.npz",
        simulated=expand("results/{{device}}/drift/{contender}.npz", contender=DRAWN),
    output:
        drift=figure("drift_{device}", "Navigation", "free-inertial drift (figure), {device}"),
        raw=figure(
            "differences_raw_{device}",
            "Navigation",
            "measured - simulated, raw (figure), {device}",
            caption="differences",
        ),
        calibrated=figure(
            "differences_calibrated_{device}",
            "Navigation",
            "measured - simulated, calibrated (figure), {device}",
            caption="differences",
        ),
    log:
        "logs/drift_figures/{device}.log",
    params:
        contenders=DRAWN,
        length_s=config["navigation"]["table_horizon_s"],
        drawn=config["navigation"]["published_trials"],
        code=library("drift_figures"),
    script:
        "../scripts/drift_figures.py"


rule drift_tables:
    """Tabulate the five-trial comparison as the source has it, the distributions, and how the ranking depends on length."""
    input:
        errors="results/{device}/drift_errors.parquet",
        proper="results/{device}/drift_crps.parquet",
        scores="results/{device}/drift_scores.csv",
        indices="results/{device}/indices.csv",
        static="data/published/he2023_table2_static_navigation.csv",
    output:
        five=table("five_trials_{device}", "Navigation", "five trials (table), {device}"),
        distribution=table("distribution_{device}", "Navigation", "distribution over trials (table), {device}"),
        ranking=table("ranking_{device}", "Navigation", "ranking over length (table), {device}"),
        figure=figure("ranking_{device}", "Navigation", "ranking over length (figure), {device}"),
        crps=figure("crps_{device}", "Navigation", "proper score over length (figure), {device}"),
        numbers="paper/numbers/navigation_{device}.json",
    log:
        "logs/drift_tables/{device}.log",
    params:
        table_horizon_s=config["navigation"]["table_horizon_s"],
        published_trials=config["navigation"]["published_trials"],
        seed=config["seed"],
        code=library("drift_tables"),
    script:
        "../scripts/drift_tables.py"


PAPER["study"] += [*of_devices(rules.drift_figures), *of_devices(rules.drift_tables)]
