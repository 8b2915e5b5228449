"""Spectra and what follows from them: Allan variance, wavelet filters, spectrograms, fractional noise.

May import nothing but its neighbours in :mod:`imugap.numerics`.
"""
