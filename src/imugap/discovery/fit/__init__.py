"""Fit of a description to the samples of one axis: mean by least squares, spectrum by Whittle likelihood.

May import preparation and effects.
"""
