rule story_hidden:
    """Seal a log in which two effects are hidden, the example of the chapter on discovery."""
    input:
        recipe="benchmark/src/imu_benchmark/recipe.toml",
    output:
        log="results/story/cases/hidden/log.parquet",
        key="results/story/keys/hidden.json",
    log:
        "logs/story_hidden.log",
    params:
        effects={"temperature": 30.0, "sinusoid": 30.0},
        seed=config["seed"],
        duration_s=900,
        rate_hz=25.0,
        code=library("story_hidden"),
    script:
        "../scripts/story_hidden.py"


rule story_page:
    """Compare what was found in the log of the example with what was hidden in it, and show the distances."""
    input:
        report="results/story/hidden/report.json",
        figure="results/story/hidden/surest.svg",
        key="results/story/keys/hidden.json",
    output:
        table=table("story", "Discovery", "an example (table)", caption="story"),
        figure=figure("story", "Discovery", "an example (figure)", caption="story"),
        numbers="paper/numbers/story.json",
    log:
        "logs/story_page.log",
    params:
        code=library("story_page"),
    script:
        "../scripts/story_page.py"


for device in MISSING_OF:

    rule:
        """Average every run of a device over blocks, as the input of discovery."""
        name:
            f"means_{device}"
        input:
            logs=per_run(device, "log.parquet"),
            clock=f"paper/tables/clock_{device}.csv",
        output:
            per_run(device, "means.parquet"),
        log:
            f"logs/means/{device}.log",
        priority: 1
        params:
            runs=RUNS[device],
            duration_s=config["discovery"]["duration_s"],
            rate_hz=config["estimation"]["rate_hz"],
            code=library("means"),
        script:
            "../scripts/means.py"


rule run_nbk:
    """Build N + B + K from the indices of one run alone, so that the other runs are unseen by it."""
    input:
        indices="results/{device}/{run}/indices.csv",
        allan="results/{device}/{run}/allan.csv",
    output:
        "results/{device}/{run}/nbk.yaml",
    log:
        "logs/run_nbk/{device}_{run}.log",
    priority: 1
    params:
        period_s=config["bias_stability_period_s"],
        code=library("run_nbk"),
    script:
        "../scripts/run_nbk.py"


if SIGHTED:

    rule sighted:
        """Cut the motion of every trial, and the error-free log that the cameras give of it, to the same band."""
        input:
            logs=expand("results/broad/{run}/log.parquet", run=SIGHTED),
            references=expand("results/broad/{run}/reference.parquet", run=SIGHTED),
            raw=[str(locate(CATALOGUE["broad"].file(run), RAW, MIRROR)) for run in SIGHTED],
            tables=["data/datasets.csv", "data/files.csv"],
        output:
            logs=expand("results/broad/{run}/sighted/log.parquet", run=SIGHTED),
            ideals=expand("results/broad/{run}/sighted/ideal.parquet", run=SIGHTED),
            noises=expand("results/broad/{run}/sighted/noise.csv", run=SIGHTED),
        log:
            "logs/sighted.log",
        priority: 1
        params:
            trials=SIGHTED,
            site=SITES["broad"],
            bandwidth_hz=config["discovery"]["bandwidth_hz"],
            margin_s=config["attitude"]["rest_margin_s"],
            code=library("sighted"),
        script:
            "../scripts/sighted.py"


rule dossier:
    """Find where a log and a simulator disagree, and name, add and show what is missing from the error model."""
    input:
        files=discovery_inputs,
        effects=own_effects,
    output:
        "results/{discovery}/report.json",
        "results/{discovery}/model.yaml",
        "results/{discovery}/gaps.csv",
        "results/{discovery}/candidates.csv",
        "results/{discovery}/parameters.csv",
        "results/{discovery}/report.md",
        report(
            "results/{discovery}/report.html",
            caption="../report/dossier.rst",
            category="Discovery",
            labels={"result": "{discovery}"},
        ),
        report(
            expand(
                "results/{{discovery}}/{figure}.svg",
                figure=["places", "surest", "distance", "drift"],
            ),
            caption="../report/dossier.rst",
            category="Discovery",
            labels={"result": "{discovery}"},
        ),
    log:
        "logs/dossier/{discovery}.log",
    wildcard_constraints:
        discovery="(discover|story|missing|motion|recordings|devices)/[^/]+",
    priority: 1
    threads: lambda wildcards: 1 if wildcards.discovery.startswith(("story/", "motion/", "recordings/", "devices/")) else 2
    resources:
        mem_mb=3000,
        runtime=lambda wildcards: 120 if wildcards.discovery.startswith("missing/") else 30,
    params:
        files=discovery_files,
        states=discovery_states,
        settings=DISCOVERY_SETTINGS,
        seed=config["seed"],
        effects=lambda wildcards: DISCOVERIES[wildcards.discovery].get("effects"),
        code=library("dossier"),
    script:
        "../scripts/dossier.py"


rule unseen_runs:
    """Score every contender and the discovered models on each run of a device, fitted to the other runs alone."""
    input:
        logs=of_runs("means.parquet"),
        starts=of_runs("nbk.yaml"),
        indices=of_runs("indices.csv"),
        allan=of_runs("allan.csv"),
    output:
        scores="results/{device}/unseen.csv",
    log:
        "logs/unseen_runs/{device}.log",
    priority: 1
    threads: 2
    resources:
        mem_mb=3000,
        runtime=120,
    params:
        runs=lambda wildcards: RUNS[wildcards.device],
        names=STARTS,
        settings=DISCOVERY_SETTINGS,
        seed=config["seed"],
        period_s=config["bias_stability_period_s"],
        code=library("unseen_runs"),
    script:
        "../scripts/unseen_runs.py"


rule unseen_page:
    """Tabulate and draw the scores of all contenders on unseen runs, paired with the discovered model."""
    input:
        scores="results/{device}/unseen.csv",
    output:
        table=table("unseen_{device}", "Discovery", "scores on unseen runs (table), {device}", caption="unseen"),
        figure=figure("unseen_{device}", "Discovery", "scores on unseen runs (figure), {device}", caption="unseen"),
        numbers="paper/numbers/unseen_{device}.json",
    log:
        "logs/unseen_page/{device}.log",
    params:
        code=library("unseen_page"),
    script:
        "../scripts/unseen_page.py"


rule missing_page:
    """Tabulate what is missing from the models of a device, where, and how far the discrepancy shrinks on other runs."""
    input:
        reports=expand("results/missing/{{device}}_{start}/report.json", start=STARTS),
        figures=expand(
            "results/missing/{{device}}_{start}/{figure}.svg",
            start=STARTS,
            figure=["surest", "distance", "drift"],
        ),
    output:
        effects=table("missing_effects_{device}", "Discovery", "what is missing (tables), {device}", caption="missing"),
        places=table("missing_places_{device}", "Discovery", "what is missing (tables), {device}", caption="missing"),
        withheld=table(
            "missing_withheld_{device}", "Discovery", "what is missing (tables), {device}", caption="missing"
        ),
        distances=table(
            "missing_distances_{device}", "Discovery", "what is missing (tables), {device}", caption="missing"
        ),
        figures=expand(
            "paper/figures/missing_{{device}}_{start}_{figure}.svg",
            start=STARTS,
            figure=["surest", "distance", "drift"],
        ),
        numbers="paper/numbers/missing_{device}.json",
    log:
        "logs/missing_page/{device}.log",
    params:
        starts=STARTS,
        code=library("missing_page"),
    script:
        "../scripts/missing_page.py"


rule motion_page:
    """Tabulate what discovery names on trials in motion, whether trials agree, and what the model of one says of another."""
    input:
        reports=expand("results/motion/broad_{run}/report.json", run=SIGHTED),
        models=expand("results/motion/broad_{run}/model.yaml", run=SIGHTED),
        logs=expand("results/broad/{run}/sighted/log.parquet", run=SIGHTED),
        ideals=expand("results/broad/{run}/sighted/ideal.parquet", run=SIGHTED),
        noises=expand("results/broad/{run}/sighted/noise.csv", run=SIGHTED),
    output:
        effects=table("motion_effects", "Discovery", "what is missing in motion (tables)", caption="motion"),
        explained=table("motion_explained", "Discovery", "what is missing in motion (tables)", caption="motion"),
        distances=table("motion_distances", "Discovery", "what is missing in motion (tables)", caption="motion"),
        figure=figure("motion_effects", "Discovery", "what is missing in motion (figure)", caption="motion"),
        numbers="paper/numbers/motion.json",
    log:
        "logs/motion_page.log",
    params:
        trials=SIGHTED,
        seed=config["seed"],
        code=library("motion_page"),
    script:
        "../scripts/motion_page.py"


rule missing_score:
    """Compare what was found on the virtual bench, in one run and in all of them together, with its truth."""
    input:
        reports=expand("results/missing/bench_{start}/report.json", start=[*STARTS, "runs"]),
        truth="results/bench/truth.json",
        logs=lambda _: per_run("bench", "means.parquet"),
    output:
        table=table("missing_score", "Discovery", "what is missing against truth (table), bench"),
        repeated=table("missing_repeated", "Discovery", "temperature in one run and in all (table), bench"),
        numbers="paper/numbers/missing_score.json",
    log:
        "logs/missing_score.log",
    params:
        starts=[*STARTS, "runs"],
        code=library("missing_score"),
    script:
        "../scripts/missing_score.py"


PAPER["discovery"] += rules.story_page.output
PAPER["discovery"] += expand(rules.missing_page.output, device=MISSING_OF)
PAPER["discovery"] += expand(rules.unseen_page.output, device=UNSEEN_OF)
PAPER["discovery"] += rules.motion_page.output if SIGHTED else []
PAPER["discovery"] += rules.missing_score.output if "bench" in MISSING_OF else []
