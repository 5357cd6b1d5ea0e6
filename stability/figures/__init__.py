"""Datasets to figures and films.

Matplotlib is imported here and above only.  May import `maps`, `motion` and the floors below.
To add a figure: a module with one function from a dataset to a Matplotlib `Figure`, drawn within
`figure_style` of `canvas.py`; nothing is computed here.  Figures and films of a motion are in
`launch`, those of spectra and maps here.
"""
