"""Start models from the files of simulators and filters: one reader per file, recognised by content.

What each key means is stated, with its source, in :mod:`imugap.interchange.conventions`.
"""
