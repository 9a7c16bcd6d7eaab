"""Limits linear algebra to one thread."""

from __future__ import annotations

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""For the environment, before NumPy is imported.

Our matrices are small: threads cost more than they save, fight over the cores of a batch, and let
the last digit of a sum depend on the number of cores.
"""
