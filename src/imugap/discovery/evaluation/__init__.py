"""Distances between measured and simulated logs on held-out data, with the start model and with the final one.

May import search, views, fit and preparation.
"""
