"""Count how often discovery is right, on cases whose hidden effects it does not know.

Sealing writes the cases, scores compares answers with them. May import the library, but its sealed half
(:mod:`imugap.benchmark.sealing`) imports neither effects nor discovery: it generates the logs by code of its own.
"""
