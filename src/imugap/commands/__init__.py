"""Commands of the command line: one module per command with its arguments, its stages and its output.

Each has ``add_arguments(parser)`` and ``run(options)``; :mod:`imugap.cli` imports the one that is asked for, and
shows on a terminal how long it runs, unless it sets ``own_progress``.
May import everything below: discovery, simulation, navigation, estimation, interchange, io.
"""
