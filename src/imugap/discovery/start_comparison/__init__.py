"""Parameters of the start model beside those of the log.

May import the stages of discovery, and the start models of the interchange.
"""
