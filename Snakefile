from snakemake.utils import min_version

min_version("9.10")


configfile: "workflow/config/study.yaml"


report: "workflow/report/study.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/data.smk"
include: "workflow/rules/static.smk"
include: "workflow/rules/models.smk"
include: "workflow/rules/navigation.smk"
include: "workflow/rules/audit.smk"
include: "workflow/rules/tutorial.smk"
include: "workflow/rules/estimation.smk"
include: "workflow/rules/planar.smk"
include: "workflow/rules/attitude.smk"
include: "workflow/rules/drive.smk"
include: "workflow/rules/walks.smk"
include: "workflow/rules/discover.smk"
include: "workflow/rules/blind.smk"
include: "workflow/rules/export.smk"
include: "workflow/rules/speed.smk"
include: "workflow/rules/paper.smk"
include: "workflow/rules/site.smk"


rule all:
    default_target: True
    input:
        "paper/paper.pdf",
        expand("results/notebooks/{name}.html", name=NOTEBOOKS),


rule discover:
    """What is missing from the model of a log of your own: --config log=PATH [test=PATH reference=PATH model=PATH]."""
    input:
        dossier_of_log,


rule blind:
    """The blind benchmark of discovery: tables in results/blind, figures in paper/figures."""
    input:
        "paper/numbers/blind.json",
