FIGURES = [
    "allan",
    "models",
    "drift",
    "differences_raw",
    "differences_calibrated",
    "ranking",
    "crps",
]
TABLES = [
    "integrity",
    "indices",
    "models",
    "five_trials",
    "distribution",
    "ranking",
]
CHAPTERS = expand(
    "paper/chapters/{name}.typ",
    name=[
        "question",
        "data",
        "indices",
        "models",
        "navigation",
        "claims",
        "conclusion",
        "reproduce",
    ],
)
CLOCKED = [device for device in DEVICES if len(RUNS[device]) > 1]


rule study_numbers:
    """Write what the text says of the study itself: devices, sections left out, choices, versions."""
    input:
        tables=["data/datasets.csv", "data/files.csv"],
        navigation=expand("paper/numbers/navigation_{device}.json", device=DEVICES),
        code=library("study_numbers"),
    output:
        "paper/numbers/study.json",
        multiext("paper/tables/datasets", ".csv", ".json", ".tex"),
    log:
        "logs/study_numbers.log",
    benchmark:
        "benchmarks/study_numbers.tsv"
    params:
        runs={device: RUNS[device] for device in DEVICES},
        power_cycles=POWER_CYCLES,
        omitted=OMITTED,
        config=config,
    script:
        "../scripts/study_numbers.py"


rule paper:
    """Compile the paper; it types no number."""
    input:
        expand("paper/figures/{name}_{device}.svg", name=FIGURES, device=DEVICES),
        expand("paper/tables/{name}_{device}.json", name=TABLES, device=DEVICES),
        expand("paper/numbers/navigation_{device}.json", device=DEVICES),
        expand("paper/numbers/models_{device}.json", device=DEVICES),
        expand("paper/numbers/clock_{device}.json", device=CLOCKED),
        ["paper/tables/bench_score.json"] if "bench" in DEVICES else [],
        ["paper/tables/turn_on.json"] if POWER_CYCLES else [],
        "paper/tables/datasets.json",
        "paper/tables/audit.json",
        "paper/tables/claims.json",
        "paper/tables/speed.json",
        "paper/numbers/study.json",
        main="paper/main.typ",
        chapters=CHAPTERS,
        style="paper/style.typ",
        bibliography="paper/references.bib",
    output:
        report("paper/paper.pdf", caption="../report/paper.rst", category="Paper"),
    log:
        "logs/paper.log",
    benchmark:
        "benchmarks/paper.tsv"
    script:
        "../scripts/paper.py"


rule notebook:
    """Execute a notebook, which reads results and explains them."""
    input:
        "paper/paper.pdf",
        notebook="notebooks/{name}.ipynb",
    output:
        report(
            "results/notebooks/{name}.html",
            caption="../report/notebook.rst",
            category="Notebooks",
            labels={"notebook": "{name}"},
        ),
    log:
        "logs/notebook/{name}.log",
    benchmark:
        "benchmarks/notebook/{name}.tsv"
    script:
        "../scripts/notebook.py"
