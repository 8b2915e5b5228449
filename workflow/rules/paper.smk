rule study_numbers:
    """Write what the text says of the study itself: devices, sections left out, choices, versions."""
    input:
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        numbers="paper/numbers/study.json",
        table=table("datasets"),
    log:
        "logs/study_numbers.log",
    params:
        runs={device: RUNS[device] for device in DEVICES},
        power_cycles=POWER_CYCLES,
        walks=WALKS,
        protocol=PROTOCOL,
        missing_of=MISSING_OF,
        unseen_of=UNSEEN_OF,
        sighted=SIGHTED,
        recordings=RECORDINGS,
        omitted=OMITTED,
        config=config,
        code=library("study_numbers"),
    script:
        "../scripts/study_numbers.py"


rule paper:
    """Compile the paper, also as a web page, and its summary; list the statements with their cells; type no number."""
    input:
        [path for chapter in CHAPTERS for path in PAPER[chapter]],
        rules.study_numbers.output,
        main="paper/main.typ",
        chapters=sorted(map(str, Path("paper").glob("*/*.typ"))),
        summary="paper/summary.typ",
        style="paper/style.typ",
        answers="paper/answers.typ",
        bibliography="paper/references.bib",
    output:
        pdf=report("paper/paper.pdf", caption="../report/paper.rst", category="Paper"),
        page=directory("results/paper"),
        summary=report("paper/summary.pdf", caption="../report/summary.rst", category="Paper"),
        statements=table("statements", "Paper", "statements (table)"),
    log:
        "logs/paper.log",
    params:
        code=library("paper"),
    script:
        "../scripts/paper.py"


rule notebook:
    """Execute a notebook, which needs the library and the recipes alone."""
    input:
        notebook="notebooks/{name}.ipynb",
        recipes=multiext("data/", "bench.yaml", "walk.yaml", "drive.yaml"),
    output:
        "results/notebooks/{name}.ipynb",
        page=report(
            "results/notebooks/{name}.html",
            caption="../report/notebook.rst",
            category="Notebooks",
            labels={"result": "{name}"},
        ),
    log:
        "logs/notebook/{name}.log",
    params:
        code=digest(),
    script:
        "../scripts/notebook.py"
