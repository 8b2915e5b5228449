PLANAR_CASES = list(TRUTHS)


rule planar_runs:
    """Navigate the two-dimensional example many times with every filter under one truth."""
    input:
        recipe="data/planar.yaml",
    output:
        spread="results/planar/{case}_spread.parquet",
        ends="results/planar/{case}_ends.parquet",
        nees="results/planar/{case}_nees.parquet",
    log:
        "logs/planar_runs/{case}.log",
    wildcard_constraints:
        case="|".join(PLANAR_CASES),
    params:
        seed=config["seed"],
        runs=config["planar"]["runs"],
        code=library("planar_runs"),
    script:
        "../scripts/planar_runs.py"


rule planar_page:
    """Draw and tabulate what each filter of the two-dimensional example believes against what it does."""
    input:
        recipe="data/planar.yaml",
        spread=expand("results/planar/{case}_spread.parquet", case=PLANAR_CASES),
        ends=expand("results/planar/{case}_ends.parquet", case=PLANAR_CASES),
        nees=expand("results/planar/{case}_nees.parquet", case=PLANAR_CASES),
    output:
        multiext("paper/tables/planar", ".json", ".tex"),
        gauss_markov=report(
            "paper/figures/planar_gauss_markov.svg",
            caption="../report/planar_spread.rst",
            category="Augmentation",
            labels={"result": "predicted and actual error (figure)"},
        ),
        flicker=report(
            "paper/figures/planar_flicker.svg",
            caption="../report/planar_spread.rst",
            category="Augmentation",
            labels={"result": "predicted and actual error, flicker (figure)"},
        ),
        consistency=report(
            "paper/figures/planar_consistency.svg",
            caption="../report/planar_consistency.rst",
            category="Augmentation",
            labels={"result": "NEES over time (figure)"},
        ),
        table=report(
            "paper/tables/planar.csv",
            caption="../report/planar.rst",
            category="Augmentation",
            labels={"result": "at the ends of the outages (table)"},
        ),
        numbers="paper/numbers/planar.json",
    log:
        "logs/planar_page.log",
    params:
        runs=config["planar"]["runs"],
        code=library("planar_page"),
    script:
        "../scripts/planar_page.py"


PAPER["augmentation"] += expand(
    "paper/figures/planar_{name}.svg", name=[*TRUTHS, "consistency"]
)
PAPER["augmentation"] += ["paper/tables/planar.json", "paper/numbers/planar.json"]
