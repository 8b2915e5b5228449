"""Find where simulation and measurement disagree, name the missing effect, add it, show the gap shrink.

:func:`imugap.discovery.dossier.compose` works on files and writes a folder; :func:`imugap.discovery.discover.discover`
works on tables.
"""
