"""What is wrong with stamps and samples of a recording: gaps, jitter, clock, lattice, saturation.

May import log, units, stream, numerics.
"""
