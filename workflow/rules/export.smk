rule conversion_table:
    """Tabulate what filters and simulators take for the noise of a sensor, with the values of every device."""
    input:
        models=expand("results/{device}/models/nbk.yaml", device=DEVICES),
        logs=[f"results/{device}/{RUNS[device][0]}/log.parquet" for device in DEVICES],
    output:
        report(
            "paper/tables/conversion.csv",
            caption="../report/conversion.rst",
            category="Augmentation",
            labels={"result": "conventions of filters and simulators (table)"},
        ),
        "paper/tables/conversion.json",
        "paper/tables/conversion.tex",
    log:
        "logs/conversion_table.log",
    params:
        devices=DEVICES,
        horizon_s=config["export"]["horizon_s"],
        code=library("conversion_table"),
    script:
        "../scripts/conversion_table.py"


PAPER["augmentation"] += ["paper/tables/conversion.json"]
