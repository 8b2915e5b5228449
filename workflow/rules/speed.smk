rule speed:
    """Time the kernels against their peers, and the chain from raw logs to indices; alone on the machine."""
    input:
        raw=[str(locate(CATALOGUE["adis16405"].file(run), RAW, MIRROR)) for run in RUNS["adis16405"]],
        recipe="data/indirect.yaml",
        walk="data/walk.yaml",
        drive="data/drive.yaml",
        walkers="data/published/walk_speed.csv",
    output:
        table=table("speed", "Speed", "speed (table)"),
    log:
        "logs/speed.log",
    # more than any machine here has: the rule runs alone
    threads: 256
    params:
        runs=RUNS["adis16405"],
        samples=config["speed"]["samples"],
        repeats=config["speed"]["repeats"],
        fits=config["speed"]["fits"],
        first_calls=config["speed"]["first_calls"],
        period_s=config["bias_stability_period_s"],
        code=library("speed"),
    script:
        "../scripts/speed.py"


PAPER["speed"] += rules.speed.output
