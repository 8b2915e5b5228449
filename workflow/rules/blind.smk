BLIND_CASES = [f"c{number:04}" for number in range(1, config["blind"]["cases"] + 1)]


# seconds each, less than a job of a cluster waits for
localrules:
    blind_score,
    blind_page,


rule blind_seal:
    """Draw the cases of the blind benchmark: logs with something hidden in them, and the keys in a folder of their own."""
    input:
        recipe="data/blind.yaml",
        schema="workflow/schemas/blind.schema.yaml",
    output:
        cases=directory(expand("results/blind/cases/{case}", case=BLIND_CASES)),
        key=expand("results/blind/keys/{case}.json", case=BLIND_CASES),
    log:
        "logs/blind_seal.log",
    benchmark:
        "benchmarks/blind_seal.tsv"
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
    """Name what is missing from the model of a sealed case, from its logs alone."""
    input:
        case="results/blind/cases/{case}",
    output:
        report="results/blind/discovered/{case}/report.json",
        views="results/blind/discovered/{case}/views.csv",
        seconds="results/blind/discovered/{case}/seconds.json",
    log:
        "logs/blind_discover/{case}.log",
    benchmark:
        "benchmarks/blind_discover/{case}.tsv"
    wildcard_constraints:
        case=r"c\d+",
    group:
        "blind_discover"
    resources:
        mem_mb=3000,
        runtime=10,
    params:
        asked={
            key: config["discovery"][key]
            for key in ("alpha", "replicates", "simulations")
        },
        seed=config["seed"],
        code=library("blind_discover"),
    script:
        "../scripts/blind_discover.py"


rule blind_score:
    """Compare the reports of the blind benchmark with the keys."""
    input:
        key=expand("results/blind/keys/{case}.json", case=BLIND_CASES),
        reports=expand("results/blind/discovered/{case}/report.json", case=BLIND_CASES),
        seconds=expand("results/blind/discovered/{case}/seconds.json", case=BLIND_CASES),
        views=expand("results/blind/discovered/{case}/views.csv", case=BLIND_CASES),
    output:
        cases="results/blind/cases.csv",
        effects="results/blind/effects.csv",
        parameters="results/blind/parameters.csv",
        detection="results/blind/detection.csv",
        false_alarms="results/blind/false_alarms.csv",
        confusion="results/blind/confusion.csv",
        naming="results/blind/naming.csv",
        beside="results/blind/beside.csv",
        coverage="results/blind/coverage.csv",
        closed="results/blind/closed.csv",
        p_values="results/blind/p_values.csv",
        calibration="results/blind/calibration.csv",
        run_time="results/blind/run_time.csv",
    log:
        "logs/blind_score.log",
    benchmark:
        "benchmarks/blind_score.tsv"
    params:
        clear_size=config["blind"]["clear_size"],
        code=library("blind_score"),
    script:
        "../scripts/blind_score.py"


rule blind_page:
    """Draw and tabulate the scores of the blind benchmark."""
    input:
        cases="results/blind/cases.csv",
        effects="results/blind/effects.csv",
        parameters="results/blind/parameters.csv",
        detection="results/blind/detection.csv",
        false_alarms="results/blind/false_alarms.csv",
        confusion="results/blind/confusion.csv",
        naming="results/blind/naming.csv",
        beside="results/blind/beside.csv",
        coverage="results/blind/coverage.csv",
        closed="results/blind/closed.csv",
        p_values="results/blind/p_values.csv",
        calibration="results/blind/calibration.csv",
        run_time="results/blind/run_time.csv",
        peer="data/published/gmwm_choice.csv",
    output:
        detection_figure=report(
            "paper/figures/blind_detection.svg",
            caption="../report/blind.rst",
            category="Discovery",
            labels={"result": "detection over size (figure)"},
        ),
        confusion_figure=report(
            "paper/figures/blind_confusion.svg",
            caption="../report/blind.rst",
            category="Discovery",
            labels={"result": "confusion (figure)"},
        ),
        rates_figure=report(
            "paper/figures/blind_rates.svg",
            caption="../report/blind.rst",
            category="Discovery",
            labels={"result": "rates (figure)"},
        ),
        coverage_figure=report(
            "paper/figures/blind_coverage.svg",
            caption="../report/blind.rst",
            category="Discovery",
            labels={"result": "parameters (figure)"},
        ),
        distances_figure=report(
            "paper/figures/blind_distances.svg",
            caption="../report/blind.rst",
            category="Discovery",
            labels={"result": "distances (figure)"},
        ),
        calibration_figure=report(
            "paper/figures/blind_calibration.svg",
            caption="../report/blind.rst",
            category="Discovery",
            labels={"result": "p-values (figure)"},
        ),
        rates=report(
            "paper/tables/blind_rates.csv",
            caption="../report/blind.rst",
            category="Discovery",
            labels={"result": "rates (table)"},
        ),
        detection="paper/tables/blind_detection.csv",
        coverage="paper/tables/blind_coverage.csv",
        calibration="paper/tables/blind_calibration.csv",
        beside="paper/tables/blind_beside.csv",
        peer="paper/tables/blind_peer.csv",
        others=expand(
            "paper/tables/blind_{table}.{suffix}",
            table=["rates", "detection", "coverage", "calibration", "beside", "peer"],
            suffix=["json", "tex"],
        ),
        numbers="paper/numbers/blind.json",
    log:
        "logs/blind_page.log",
    benchmark:
        "benchmarks/blind_page.tsv"
    params:
        clear_size=config["blind"]["clear_size"],
        code=library("blind_page"),
    script:
        "../scripts/blind_page.py"


PAPER["discovery"] += (
    ["paper/numbers/blind.json"] if config["blind"]["in_paper"] else []
)
