"""Figures and films of a motion.

May import what `figures` may.  `single_run.py` takes one launch out of a dataset and knows its
units; `motion_panels.py` holds the lines that figures share.
To add a figure of a motion: a module like `motion.py`.
"""
