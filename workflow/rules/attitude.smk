FLIGHTS = list(range(1, config["attitude"]["flights"] + 1))
RECIPE = yaml.safe_load(Path("data/flight.yaml").read_text())


rule flight_truth:
    """Write the true trajectory of the flight, which only scoring reads, and the true model, a control."""
    input:
        recipe="data/flight.yaml",
    output:
        trajectory="results/flight/truth.parquet",
        models="results/flight/truth.yaml",
    log:
        "logs/flight_truth.log",
    params:
        code=library("flight_truth"),
    script:
        "../scripts/flight_truth.py"


rule flight_runs:
    """Simulate the flights, and fit each device's error model to a static log ahead of its flight, by every scheme."""
    input:
        recipe="data/flight.yaml",
    output:
        flights=expand("data/raw/flight/{run}/flight.parquet", run=FLIGHTS),
        estimates=expand("results/flight/{run}/estimates.csv", run=FLIGHTS),
        models=expand("results/flight/{run}/models.yaml", run=FLIGHTS),
    log:
        "logs/flight_runs.log",
    priority: 1
    params:
        seed=config["seed"],
        runs=FLIGHTS,
        minutes=config["attitude"]["static_minutes"],
        code=library("flight_runs"),
    script:
        "../scripts/flight_runs.py"


rule flight_attitude:
    """Filter every flight with the model of every scheme."""
    input:
        logs=expand("data/raw/flight/{run}/flight.parquet", run=FLIGHTS),
        models=expand("results/flight/{run}/models.yaml", run=FLIGHTS),
    output:
        "results/flight/attitude.parquet",
    log:
        "logs/flight_attitude.log",
    params:
        heading_deg=RECIPE["course"]["heading_deg"],
        launch_s=RECIPE["course"]["launch_s"],
        assumptions=assumptions(RECIPE["site"], "flight"),
        code=library("flight_attitude"),
    script:
        "../scripts/flight_attitude.py"


use rule flight_attitude as flight_control with:
    input:
        logs=expand("data/raw/flight/{run}/flight.parquet", run=FLIGHTS),
        models=["results/flight/truth.yaml"],
    output:
        "results/flight/control.parquet",
    log:
        "logs/flight_control.log",


rule flight_scores:
    """Compare the filtered attitudes with the truth."""
    input:
        attitude="results/flight/attitude.parquet",
        control="results/flight/control.parquet",
        truth="results/flight/truth.parquet",
    output:
        scores="results/flight/scores.csv",
        differences="results/flight/differences.csv",
        errors="results/flight/errors.parquet",
    log:
        "logs/flight_scores.log",
    params:
        seed=config["seed"],
        code=library("flight_scores"),
    script:
        "../scripts/flight_scores.py"


rule flight_page:
    """Draw and tabulate the simulated flights: attitude and error, table 5 of the source, estimated parameters."""
    input:
        scores="results/flight/scores.csv",
        differences="results/flight/differences.csv",
        errors="results/flight/errors.parquet",
        truth="results/flight/truth.parquet",
        model="results/flight/truth.yaml",
        estimates=expand("results/flight/{run}/estimates.csv", run=FLIGHTS),
        published="data/published/liu2016_results.csv",
    output:
        flight=figure("attitude_flight", "Attitude", "one flight (figure)"),
        runs=figure("attitude_runs", "Attitude", "all flights (figure)"),
        table=table("attitude_flight", "Attitude", "errors in flight (table)", caption="attitude_table"),
        parameters=table("attitude_parameters", "Attitude", "estimated parameters (table)"),
        numbers="paper/numbers/attitude_flight.json",
    log:
        "logs/flight_page.log",
    params:
        seed=config["seed"],
        trials=TRIALS,
        course=RECIPE["course"],
        rate_hz=RECIPE["rate_hz"],
        code=library("flight_page"),
    script:
        "../scripts/flight_page.py"


PAPER["attitude"] += rules.flight_page.output

if TRIALS:

    rule trial_references:
        """Read the optical reference attitude of every trial."""
        input:
            raw=raw_logs("broad"),
            tables=["data/datasets.csv", "data/files.csv"],
        output:
            of_trials("reference.parquet"),
        log:
            "logs/trial_references.log",
        priority: 1
        params:
            trials=TRIALS,
            code=library("trial_references"),
        script:
            "../scripts/trial_references.py"

    rule trial_fit:
        """Estimate the error model of the device from both rests of every trial, by every scheme."""
        input:
            logs=of_trials("log.parquet"),
            references=of_trials("reference.parquet"),
        output:
            estimates="results/broad/estimates.csv",
            models="results/broad/models.yaml",
        log:
            "logs/trial_fit.log",
        params:
            trials=TRIALS,
            margin_s=config["attitude"]["rest_margin_s"],
            code=library("trial_fit"),
        script:
            "../scripts/trial_fit.py"

    rule trial_attitude:
        """Filter the motion of every trial with the model of every scheme, without and with a margin for motion."""
        input:
            logs=of_trials("log.parquet"),
            references=of_trials("reference.parquet"),
            models="results/broad/models.yaml",
        output:
            "results/broad/attitude.parquet",
        log:
            "logs/trial_attitude.log",
        params:
            trials=TRIALS,
            margin_s=config["attitude"]["rest_margin_s"],
            motion_margin=config["attitude"]["motion_margin"],
            assumptions=assumptions(SITES["broad"], "broad"),
            code=library("trial_attitude"),
        script:
            "../scripts/trial_attitude.py"

    rule trial_scores:
        """Measure how log and reference lie to one another, and compare the filtered attitudes with the reference."""
        input:
            logs=of_trials("log.parquet"),
            references=of_trials("reference.parquet"),
            attitude="results/broad/attitude.parquet",
        output:
            alignment="results/broad/alignment.csv",
            scores="results/broad/scores.csv",
            differences="results/broad/differences.csv",
            errors="results/broad/errors.parquet",
        log:
            "logs/trial_scores.log",
        params:
            trials=TRIALS,
            seed=config["seed"],
            margin_s=config["attitude"]["rest_margin_s"],
            code=library("trial_scores"),
        script:
            "../scripts/trial_scores.py"

    rule trial_page:
        """Draw and tabulate the real trials: alignment, estimates from the rests, errors."""
        input:
            alignment="results/broad/alignment.csv",
            estimates="results/broad/estimates.csv",
            scores="results/broad/scores.csv",
            differences="results/broad/differences.csv",
            errors="results/broad/errors.parquet",
        output:
            figure=figure("attitude_trials", "Attitude", "trials (figure)"),
            alignment=table("attitude_alignment", "Attitude", "log against reference (table)"),
            rests=table("attitude_rests", "Attitude", "what a rest shows (table)"),
            trials=table("attitude_trials", "Attitude", "errors of the trials (table)", caption="attitude_trials_table"),
            numbers="paper/numbers/attitude_trials.json",
        log:
            "logs/trial_page.log",
        params:
            code=library("trial_page"),
        script:
            "../scripts/trial_page.py"

    PAPER["attitude"] += rules.trial_page.output
