"""Convex bodies of revolution: equations, named bodies.

May import what `bodies` may.
To add a named body: a function in `bodies/round_body/shapes/named.py`.
Any other body is one call of `Body`.
"""
