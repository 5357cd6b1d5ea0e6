"""Settling of many states at once, by kernels in balls of doubles.

May import `stability.settling.attraction` and what that imports.
To add a kind of family near which states are placed: a class with `name`, `attracting` and `place`,
as `Place` in `many.py` asks, and a `many` of its settling.
The proof in balls of doubles is `kernel.py`; its compiled loops are `box_kernel.py`.
"""
