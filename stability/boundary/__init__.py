"""Where verdicts change.

Proved brackets along an axis, curves over two, the drift of rolling, Hopf points.
May import `spectra`, `derivation`, `integrators` and the floors below.
To add a problem about a boundary: a module with one function and one record of its answer.
"""
