"""Discovery: find where simulation and measurement disagree, name the missing effect, add it, and measure both models.

:mod:`.inputs` works on files, :mod:`.device` on tables. The stages: preparation, search of each axis, pooling of axes,
checks, comparison of runs, evaluation, description of what has no name, report. May import simulation, estimation,
effects, io and what lies below.
"""
