# Baselines and discovery on cases of their own, made, answered and scored as by anyone who enters the benchmark.
BASELINE_CASES = [f"c{number:04}" for number in range(1, config["baselines"]["cases"] + 1)]
BASELINE_BATCHES = {
    str(1 + first // config["baselines"]["cases_per_job"]): BASELINE_CASES[
        first : first + config["baselines"]["cases_per_job"]
    ]
    for first in range(0, len(BASELINE_CASES), config["baselines"]["cases_per_job"])
}


localrules:
    baselines_score,
    baselines_page,


rule baselines_make:
    """Make the cases of the comparison with baselines, and the file of their keys."""
    input:
        recipe="benchmark/src/imu_benchmark/recipe.toml",
    output:
        public=directory("results/baselines/public"),
        secret="results/baselines/secret.json",
    log:
        "logs/baselines_make.log",
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        **{key: config["baselines"][key] for key in ("cases", "seed", "changes")},
        code=library("baselines_make"),
    script:
        "../scripts/baselines_make.py"


rule baselines_answer:
    """Answer the cases with a baseline."""
    input:
        public="results/baselines/public",
    output:
        directory("results/baselines/entries/{baseline}"),
    log:
        "logs/baselines_answer/{baseline}.log",
    wildcard_constraints:
        baseline="|".join(config["baselines"]["entries"]),
    resources:
        mem_mb=2000,
        runtime=60,
    params:
        code=digest(sorted(Path("benchmark/src/imu_benchmark").rglob("*.py"))),
    script:
        "../scripts/baselines_answer.py"


rule baselines_discover:
    """Name what is missing from the model of each of a batch of cases, from its logs alone."""
    input:
        public="results/baselines/public",
    output:
        directory("results/baselines/discovered/{batch}"),
    log:
        "logs/baselines_discover/{batch}.log",
    wildcard_constraints:
        batch=r"\d+",
    resources:
        mem_mb=3000,
        runtime=10 * config["baselines"]["cases_per_job"],
    params:
        settings=DISCOVERY_SETTINGS,
        seed=config["seed"],
        cases=lambda wildcards: BASELINE_BATCHES[wildcards.batch],
        code=library("baselines_discover"),
    script:
        "../scripts/baselines_discover.py"


rule baselines_score:
    """Reveal the keys and score all entries."""
    input:
        public="results/baselines/public",
        secret="results/baselines/secret.json",
        entries=expand("results/baselines/entries/{baseline}", baseline=config["baselines"]["entries"]),
        discovered=expand("results/baselines/discovered/{batch}", batch=BASELINE_BATCHES),
    output:
        summary="results/baselines/summary.csv",
        answers="results/baselines/answers.csv",
    log:
        "logs/baselines_score.log",
    params:
        clear_size=config["blind"]["clear_size"],
        code=library("baselines_score"),
    script:
        "../scripts/baselines_score.py"


rule baselines_page:
    """Tabulate the baselines beside discovery, of a run here or of the recorded one."""
    input:
        unpack(baseline_scores),
    output:
        table=table("{baselines}", "Discovery", "baselines (table)", caption="baselines", run="{baselines}"),
        numbers="paper/numbers/{baselines}.json",
    log:
        "logs/{baselines}_page.log",
    wildcard_constraints:
        baselines="baselines|baselines_recorded",
    params:
        clear_size=config["blind"]["clear_size"],
        code=library("baselines_page"),
    script:
        "../scripts/baselines_page.py"


PAPER["discovery"] += ["paper/numbers/baselines_recorded.json"] if config["baselines"]["recorded"] else []
