BLIND_CASES = [f"c{number:04}" for number in range(1, config["blind"]["cases"] + 1)]
PER_JOB = config["blind"]["cases_per_job"]
BATCHES = {
    str(1 + first // PER_JOB): BLIND_CASES[first : first + PER_JOB] for first in range(0, len(BLIND_CASES), PER_JOB)
}


# seconds each, less than a job of a cluster waits for
localrules:
    blind_score,
    blind_page,


rule blind_seal:
    """Generate the cases of the blind benchmark: logs with hidden effects, and their keys in another folder."""
    input:
        recipe="benchmark/src/imu_benchmark/recipe.toml",
    output:
        cases=directory(expand("results/blind/cases/{case}", case=BLIND_CASES)),
        key=expand("results/blind/keys/{case}.json", case=BLIND_CASES),
    log:
        "logs/blind_seal.log",
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        cases=config["blind"]["cases"],
        seed=config["blind"]["seed"],
        code=library("blind_seal"),
    script:
        "../scripts/blind_seal.py"


rule blind_discover:
    """Name what is missing from the model of each of a batch of sealed cases, from its logs alone."""
    input:
        cases=lambda wildcards: expand("results/blind/cases/{case}", case=BATCHES[wildcards.batch]),
    output:
        directory("results/blind/discovered/{batch}"),
    log:
        "logs/blind_discover/{batch}.log",
    wildcard_constraints:
        batch=r"\d+",
    resources:
        mem_mb=3000,
        runtime=10 * PER_JOB,
    params:
        settings=DISCOVERY_SETTINGS,
        seed=config["seed"],
        code=library("blind_discover"),
    script:
        "../scripts/blind_discover.py"


rule blind_score:
    """Compare the reports of the blind benchmark with the keys."""
    input:
        key=expand("results/blind/keys/{case}.json", case=BLIND_CASES),
        found=expand("results/blind/discovered/{batch}", batch=BATCHES),
    output:
        cases="results/blind/cases.csv",
        effects="results/blind/effects.csv",
        parameters="results/blind/parameters.csv",
        p_values="results/blind/p_values.csv",
        run_time="results/blind/run_time.csv",
    log:
        "logs/blind_score.log",
    params:
        code=library("blind_score"),
    script:
        "../scripts/blind_score.py"


rule blind_page:
    """Plot and tabulate the scores of the blind benchmark, or of its recorded run."""
    input:
        unpack(blind_scores),
        peer="data/published/gmwm_choice.csv",
    output:
        detection_figure=figure(
            "{benchmark}_detection", "Discovery", "detection over size (figure)", caption="blind", run="{benchmark}"
        ),
        confusion_figure=figure(
            "{benchmark}_confusion", "Discovery", "confusion (figure)", caption="blind", run="{benchmark}"
        ),
        rates_figure=figure("{benchmark}_rates", "Discovery", "rates (figure)", caption="blind", run="{benchmark}"),
        coverage_figure=figure(
            "{benchmark}_coverage", "Discovery", "parameters (figure)", caption="blind", run="{benchmark}"
        ),
        distances_figure=figure(
            "{benchmark}_distances", "Discovery", "distances (figure)", caption="blind", run="{benchmark}"
        ),
        calibration_figure=figure(
            "{benchmark}_calibration", "Discovery", "p-values (figure)", caption="blind", run="{benchmark}"
        ),
        rates=table("{benchmark}_rates", "Discovery", "rates (table)", caption="blind", run="{benchmark}"),
        misses=table("{benchmark}_misses", "Discovery", "wrong answers (table)", caption="blind", run="{benchmark}"),
        detection=table("{benchmark}_detection"),
        confusion=table("{benchmark}_confusion"),
        coverage=table("{benchmark}_coverage"),
        calibration=table("{benchmark}_calibration"),
        beside=table("{benchmark}_beside"),
        peer=table("{benchmark}_peer"),
        numbers="paper/numbers/{benchmark}.json",
    log:
        "logs/{benchmark}_page.log",
    wildcard_constraints:
        benchmark="blind|blind_recorded",
    params:
        clear_size=config["blind"]["clear_size"],
        code=library("blind_page"),
    script:
        "../scripts/blind_page.py"


PAPER["discovery"] += ["paper/numbers/blind_recorded.json"] if config["blind"]["recorded"] else []
