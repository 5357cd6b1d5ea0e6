"""Theorems about bodies of revolution and the disk, each a list of steps that code checks.

`proof` is the form of a theorem, `mechanics` and `signs` are what proofs share; each other module
proves theorems about every height h(θ), `pole` with the axis vertical, `disk` at h = sinθ.
To add a theorem: a function that returns a `Theorem`, its entry in `catalogue`, and a cell in a
notebook that shows it.
"""
