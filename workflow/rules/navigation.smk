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
        models=expand(
            "results/{{device}}/models/{contender}.yaml", contender=CONTENDERS
        ),
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
        simulated=expand(
            "results/{{device}}/drift/{contender}.npz", contender=CONTENDERS
        ),
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
        drift=report(
            "paper/figures/drift_{device}.svg",
            caption="../report/drift.rst",
            category="Navigation",
            labels={"result": "free-inertial drift (figure), {device}"},
        ),
        raw=report(
            "paper/figures/differences_raw_{device}.svg",
            caption="../report/differences.rst",
            category="Navigation",
            labels={"result": "measured - simulated, raw (figure), {device}"},
        ),
        calibrated=report(
            "paper/figures/differences_calibrated_{device}.svg",
            caption="../report/differences.rst",
            category="Navigation",
            labels={"result": "measured - simulated, calibrated (figure), {device}"},
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
        multiext("paper/tables/five_trials_{device}", ".json", ".tex"),
        multiext("paper/tables/distribution_{device}", ".json", ".tex"),
        multiext("paper/tables/ranking_{device}", ".json", ".tex"),
        five=report(
            "paper/tables/five_trials_{device}.csv",
            caption="../report/five_trials.rst",
            category="Navigation",
            labels={"result": "five trials (table), {device}"},
        ),
        distribution=report(
            "paper/tables/distribution_{device}.csv",
            caption="../report/distribution.rst",
            category="Navigation",
            labels={"result": "distribution over trials (table), {device}"},
        ),
        ranking=report(
            "paper/tables/ranking_{device}.csv",
            caption="../report/ranking.rst",
            category="Navigation",
            labels={"result": "ranking over length (table), {device}"},
        ),
        figure=report(
            "paper/figures/ranking_{device}.svg",
            caption="../report/ranking.rst",
            category="Navigation",
            labels={"result": "ranking over length (figure), {device}"},
        ),
        crps=report(
            "paper/figures/crps_{device}.svg",
            caption="../report/crps.rst",
            category="Navigation",
            labels={"result": "proper score over length (figure), {device}"},
        ),
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


PAPER["study"] += of_devices(
    "paper/figures/drift_{device}.svg",
    "paper/figures/differences_raw_{device}.svg",
    "paper/figures/differences_calibrated_{device}.svg",
    "paper/figures/ranking_{device}.svg",
    "paper/figures/crps_{device}.svg",
    "paper/tables/five_trials_{device}.json",
    "paper/tables/distribution_{device}.json",
    "paper/tables/ranking_{device}.json",
    "paper/numbers/navigation_{device}.json",
)
