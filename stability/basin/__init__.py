"""Launches by where they end.

Maps and samples of launches (`basins`), each run until its outcome is proved (`outcomes`);
borders between outcomes, fractions, sensitivity, smallest disturbances.  The mathematics of borders
and statistics asks any function of labels, and knows no mechanics.
May import `maps`, `motion` and the floors below.
To add a measure of a map of outcomes: a module in `statistics/` that takes labels.
To add a distribution of launches: a class with `names`, `words` and `values`, as in
`statistics/samples.py`.
"""
