rule site:
    """Build the documentation as web pages, which need no network."""
    input:
        pages=sorted(str(path) for path in Path("docs").rglob("*") if path.is_file()),
        notebooks=sorted(map(str, Path("notebooks").glob("*.ipynb"))),
        plugin=multiext("notebooks/heater", ".py", ".yaml"),
        scores=["data/blind_recorded/cases.csv", "data/blind_recorded/effects.csv"],
        changes="CHANGELOG.md",
        picture="paper/overview.png",
    output:
        site=directory("results/site"),
    log:
        "logs/site.log",
    params:
        outputs=lambda wildcards: [
            [str(path), one.name, (one.docstring or "").strip()]
            for one in workflow.rules
            for path in one.output
            if str(path).startswith(("paper/figures/", "paper/tables/")) and str(path).endswith((".svg", ".csv"))
        ],
        paper=lambda wildcards: states(Path("results").glob("paper/index.html")),
        code=digest(),
    script:
        "../scripts/site.py"
