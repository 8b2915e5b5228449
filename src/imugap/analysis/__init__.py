"""Questions about a recording, one per module: what is wrong with it, its indices, its effects, its path.

Each is a function of recordings and settings that returns a value; nothing is printed or written. May import
everything below: discovery, simulation, navigation, estimation, interchange, io.
"""
