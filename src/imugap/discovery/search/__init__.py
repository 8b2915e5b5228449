"""Search for the missing effects of one axis, and for those that axes share.

May import views, fit and preparation.
"""
