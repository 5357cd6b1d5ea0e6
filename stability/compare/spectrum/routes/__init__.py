"""Routes from a steady motion to a verdict.

Routes that people use, and those of the package.  May import what `compare` may.
To add a route: a subclass of `Route` in a module here, its class in `PEOPLE` of
`compare/spectrum/measure.py`.
"""
