"""Inverse of small matrices in compiled kernels by plain loops: library routines take seconds to compile."""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def invert(matrix):
    """Return the inverse of ``matrix``, shape (n, n), and the log of its absolute determinant.

    Gauss-Jordan elimination with the largest pivot of each column (Golub and Van Loan 2013, Matrix Computations,
    section 3.4). A singular matrix gives entries that are not finite.
    """
    size = len(matrix)
    work, inverse, log_determinant = np.empty((size, size)), np.empty((size, size)), 0.0
    for i in range(size):
        for j in range(size):
            work[i, j], inverse[i, j] = matrix[i, j], 1.0 if i == j else 0.0
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(work[i, k]) > abs(work[pivot, k]):
                pivot = i
        for j in range(size):
            work[k, j], work[pivot, j] = work[pivot, j], work[k, j]
            inverse[k, j], inverse[pivot, j] = inverse[pivot, j], inverse[k, j]
        scale = 1 / work[k, k]
        log_determinant -= np.log(abs(scale))
        for j in range(size):
            work[k, j] *= scale
            inverse[k, j] *= scale
        for i in range(size):
            factor = work[i, k]
            if i != k and factor != 0.0:
                for j in range(size):
                    work[i, j] -= factor * work[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return inverse, log_determinant
