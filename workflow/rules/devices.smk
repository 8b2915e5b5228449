rule device_model:
    """Make the model of a device that is shipped with the library, with its card, of what was found on its log."""
    input:
        report=lambda wildcards: f"results/{device_discovery(wildcards.name)}/report.json",
        parameters=lambda wildcards: f"results/{device_discovery(wildcards.name)}/parameters.csv",
        tables=["data/datasets.csv", "data/files.csv"],
    output:
        model="results/devices/{name}/card.yaml",
    log:
        "logs/device_model/{name}.log",
    wildcard_constraints:
        name="|".join(DEVICE_MODELS),
    params:
        title=lambda wildcards: DEVICE_MODELS[wildcards.name]["title"],
        remarks=lambda wildcards: DEVICE_MODELS[wildcards.name]["remarks"],
        dataset=lambda wildcards: device_data(wildcards.name)[0],
        runs=lambda wildcards: device_data(wildcards.name)[1],
        in_motion=lambda wildcards: "reference" in DISCOVERIES[device_discovery(wildcards.name)],
        settings=DISCOVERY_SETTINGS | {"seed": config["seed"]},
        code=library("device_model"),
    script:
        "../scripts/device_model.py"
