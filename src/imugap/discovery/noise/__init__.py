"""Noise that several axes share, and noise without a name that is described by its spectrum and law.

May import :mod:`imugap.discovery.axis`, evaluation, checks and what lies below.
"""
