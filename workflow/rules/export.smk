rule conversion_table:
    """Tabulate what filters and simulators take for the noise of a sensor, with the values of every device."""
    input:
        models=expand("results/{device}/models/nbk.yaml", device=DEVICES),
        logs=[f"results/{device}/{RUNS[device][0]}/log.parquet" for device in DEVICES],
    output:
        table=table("conversion", "Augmentation", "conventions of filters and simulators (table)"),
    log:
        "logs/conversion_table.log",
    params:
        devices=DEVICES,
        horizon_s=config["export"]["horizon_s"],
        code=library("conversion_table"),
    script:
        "../scripts/conversion_table.py"


PAPER["augmentation"] += rules.conversion_table.output
