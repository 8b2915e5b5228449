"""Pages: the result of an analysis as one HTML file that needs nothing else, to read on any screen or on paper.

A page is a tree of blocks (:mod:`imugap.pages.page`) that one template renders (:mod:`imugap.pages.render`); one
module per analysis composes its page. May import figures and what lies below.
"""
