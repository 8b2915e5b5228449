include: "workflow/Snakefile"


rule study:
    # an included file sets no default target
    default_target: True
    input:
        rules.all.input,
