"""What a log is compared with: reference attitudes, poses, motion capture.

May import its neighbours in :mod:`imugap.io` and what lies below.
"""
