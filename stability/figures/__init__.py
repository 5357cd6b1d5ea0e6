"""Datasets to figures and films.

Only this folder and the floors above import Matplotlib.
May import `basin`, `scene` and the floors below.
To add a figure: a module with one function from a dataset to a Matplotlib `Figure`, drawn within
`figure_style` of `canvas.py`; it computes nothing.  `styled_figure.py` writes legends, labels,
words and notes around panels, `single_run.py` takes one launch out of a dataset, `fates.py` gives
every end of a launch its colour, `modes.py` parts a spectrum into modes.
"""
