"""Public functions and results: what ``import imugap`` offers, and what the command line is made of.

One module per question. A result is a frozen value with documented attributes that prints as its verdict, shows itself
in a notebook, draws itself with ``plot()``, and writes its folder with ``report(folder)``. Attributes of results and
parameters of functions here follow semantic versioning; everything below may change with any version. The package lies
above pages and figures, which its results show, and below the commands, which only parse, call and print.
"""
