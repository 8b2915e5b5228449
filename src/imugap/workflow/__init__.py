"""What rules and scripts of the workflow need: dependencies of a script, job log, tables for the paper.

May import log, units, atomic, stream, numerics.
"""
