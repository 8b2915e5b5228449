"""How far apart measured and simulated runs are, and how much nearer they come on runs no fit has seen.

May import search, views, fit and preparation.
"""
