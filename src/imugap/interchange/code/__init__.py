"""Error models as source code without dependencies: one file, one sample at a time, seeded.

Effects give their steps (:mod:`imugap.effects.block`); one template for each language holds the rest.
"""
