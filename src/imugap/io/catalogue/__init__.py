"""Data sets of the study: their files, sources, checksums and download, and the readers of their formats.

May import its neighbours in :mod:`imugap.io` and what lies below.
"""
