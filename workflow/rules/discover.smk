rule dossier:
    """Find where a log and a simulator disagree, and name, add and show what is missing from the error model."""
    input:
        log=OPTIONS["log"],
        test=OPTIONS["test"],
        reference=OPTIONS["reference"],
        model=OPTIONS["model"],
        effects=[str(OWN_EFFECTS)] if OWN_EFFECTS.is_file() else [],
        code=library("dossier"),
    output:
        "results/discover/{name}/report.json",
        "results/discover/{name}/model.yaml",
        "results/discover/{name}/gaps.csv",
        "results/discover/{name}/candidates.csv",
        report(
            "results/discover/{name}/report.md",
            caption="../report/dossier.rst",
            category="Discovery",
            labels={"result": "{name}"},
        ),
        report(
            expand(
                "results/discover/{{name}}/{figure}.svg",
                figure=["places", "distance", "drift"],
            ),
            caption="../report/dossier.rst",
            category="Discovery",
            labels={"result": "{name}"},
        ),
    log:
        "logs/dossier/{name}.log",
    benchmark:
        "benchmarks/dossier/{name}.tsv"
    threads: 2
    resources:
        mem_mb=3000,
        runtime=30,
    params:
        alpha=config["discovery"]["alpha"],
        seed=config["seed"],
        effects=config["effects"],
    script:
        "../scripts/dossier.py"
