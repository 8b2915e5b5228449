"""Readers of recordings: logs, fixes, references, camera tracks; data sets and configurations.

May import effects only through the floors below: kinematics, integrity, log, units.
"""
