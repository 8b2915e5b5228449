"""Simulated recordings whose truth is known: virtual bench, walks, drives, flights, GNSS faults.

May import navigation, filters, estimation and what lies below.
"""
