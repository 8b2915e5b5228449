"""Find where simulation and measurement disagree, name the missing effect, add it, show the gap shrink.

:func:`discover` works on files and writes a report; :func:`imugap.discovery.discover.discover` on tables.
"""
