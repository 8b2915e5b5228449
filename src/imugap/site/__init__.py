"""Pages of the documentation that are made from the library itself, as Markdown (MyST).

One module per page; the others are files in ``docs``. May import api, figures and what lies below, and the scores of
the benchmark.
"""
