"""What rules and scripts of the workflow need: dependencies, log and products of a job, tables of the paper.

May import log, units, atomic, stream, numerics.
"""
