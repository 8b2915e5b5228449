"""Commands of the command line: one file per command with its arguments, its stages and its output folder.

May import everything below: discovery, simulation, navigation, estimation, interchange, io.
"""
