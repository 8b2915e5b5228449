"""Questions of the study: one module per question, from tables of results to tables of the paper.

May import discovery, simulation, navigation, filters, estimation and what lies below.
"""
