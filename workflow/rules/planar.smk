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
        gauss_markov=figure(
            "planar_gauss_markov", "Augmentation", "predicted and actual error (figure)", caption="planar_spread"
        ),
        flicker=figure(
            "planar_flicker", "Augmentation", "predicted and actual error, flicker (figure)", caption="planar_spread"
        ),
        consistency=figure("planar_consistency", "Augmentation", "NEES over time (figure)"),
        table=table("planar", "Augmentation", "at the ends of the outages (table)"),
        numbers="paper/numbers/planar.json",
    log:
        "logs/planar_page.log",
    params:
        runs=config["planar"]["runs"],
        code=library("planar_page"),
    script:
        "../scripts/planar_page.py"


PAPER["augmentation"] += rules.planar_page.output
