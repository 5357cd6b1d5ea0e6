"""Figures and films of a motion.

May import what `figures` may.  `single_run.py` takes one launch out of a dataset.
`motion_panels.py` holds the pieces that figures share, units of the axes among them.
To add a figure of a motion: a module like `motion.py`.
"""
