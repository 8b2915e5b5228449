"""Blind benchmark of discovery: cases with hidden effects, and scores of the answers.

Module scores compares reports with keys. The sealed half (:mod:`imugap.benchmark.sealing`) generates cases and keys
by its own code and imports neither effects, models nor discovery.
"""
