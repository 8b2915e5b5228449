"""Formats of recordings: one file per format, with how it is recognised by content and which columns it has.

A format has ``recognises(path, head)`` and ``open_source(path, settings)``. May import recognition and log.
"""
