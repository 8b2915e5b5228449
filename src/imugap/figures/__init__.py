"""Figures: :mod:`imugap.figures.style`, and one module per chapter; tables in, matplotlib figures out.

May import the library below, for names, units and constants of what is drawn; computes no result.
"""
