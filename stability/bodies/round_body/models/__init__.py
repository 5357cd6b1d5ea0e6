"""The record that a launch needs of a body, in angles or along fixed axes.

May import what `bodies/round_body` may.
To add a chart: a module that makes a `Model` with a `Chart`, and its place in
`motion/round_starts.py`.
"""
