"""Fixes of a GNSS receiver in the formats of receivers and programs: one file per format.

A format has ``recognises(path, head)`` and ``decode(path, settings)`` (:class:`imugap.io.fixes.decoded.Decoded`).
May import formats, recognition, gnss.
"""
