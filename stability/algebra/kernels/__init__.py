"""Kernels: plain functions of numbers, compiled where Numba is installed.

May import `base` and the modules directly in `algebra`.
To add a kernel: a module of plain functions that import NumPy and `math` alone, given to
`compiled` in `compiled.py`.
"""
