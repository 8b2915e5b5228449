"""Benchmark of programs that find what is missing from the error model of an inertial sensor.

A benchmark has cases, logs of devices in which effects are hidden or none, and keys, which say what is hidden. A
program gets the cases and answers each with a report; the scores compare reports with keys.

Modules: sealing makes cases and keys; scores compares reports with keys. Needs NumPy, SciPy and pandas.

Units are SI: rad/s, m/s^2, s, Hz; temperature in degC.
"""
