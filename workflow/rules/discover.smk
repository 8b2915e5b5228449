rule story_hidden:
    """Seal the log of the notebook that tells of discovery, in which two effects are hidden."""
    input:
        recipe="data/blind.yaml",
        schema="workflow/schemas/blind.schema.yaml",
        code=library("story_hidden"),
    output:
        log="results/story/cases/hidden/log.parquet",
        key="results/story/keys/hidden.json",
    log:
        "logs/story_hidden.log",
    benchmark:
        "benchmarks/story_hidden.tsv"
    params:
        effects={"temperature": 30.0, "sinusoid": 30.0},
        seed=config["seed"],
        duration_s=900,
        rate_hz=25.0,
    script:
        "../scripts/story_hidden.py"


rule story_heater:
    """Simulate the log of a device with an effect that the catalogue does not have."""
    input:
        model="notebooks/heater.yaml",
        effects="notebooks/heater.py",
        code=library("story_heater"),
    output:
        "results/story/heater.parquet",
    log:
        "logs/story_heater.log",
    benchmark:
        "benchmarks/story_heater.tsv"
    params:
        effects="notebooks.heater",
        seed=config["seed"],
        duration_s=600,
        rate_hz=25.0,
    script:
        "../scripts/story_heater.py"


rule story_real:
    """Cut the gyroscopes of two real runs short, as means at a lower rate."""
    input:
        expand("results/adis16405/{run}/log.parquet", run=RUNS["adis16405"][:2]),
        code=library("story_real"),
    output:
        "results/story/real_log.parquet",
        "results/story/real_test.parquet",
    log:
        "logs/story_real.log",
    benchmark:
        "benchmarks/story_real.tsv"
    params:
        duration_s=1800,
        rate_hz=config["estimation"]["rate_hz"],
    script:
        "../scripts/story_real.py"


rule dossier:
    """Find where a log and a simulator disagree, and name, add and show what is missing from the error model."""
    input:
        log=asked("log"),
        test=asked("test"),
        reference=asked("reference"),
        model=asked("model"),
        effects=own_effects,
        code=library("dossier"),
    output:
        "results/{asked}/report.json",
        "results/{asked}/model.yaml",
        "results/{asked}/gaps.csv",
        "results/{asked}/candidates.csv",
        report(
            "results/{asked}/report.md",
            caption="../report/dossier.rst",
            category="Discovery",
            labels={"result": "{asked}"},
        ),
        report(
            expand(
                "results/{{asked}}/{figure}.svg",
                figure=["places", "distance", "drift"],
            ),
            caption="../report/dossier.rst",
            category="Discovery",
            labels={"result": "{asked}"},
        ),
    log:
        "logs/dossier/{asked}.log",
    benchmark:
        "benchmarks/dossier/{asked}.tsv"
    wildcard_constraints:
        asked="(discover|story)/[^/]+",
    threads: lambda wildcards: 2 if wildcards.asked.startswith("discover/") else 1
    resources:
        mem_mb=3000,
        runtime=30,
    params:
        alpha=config["discovery"]["alpha"],
        seed=config["seed"],
        effects=lambda wildcards: ASKED[wildcards.asked].get("effects"),
    script:
        "../scripts/dossier.py"
