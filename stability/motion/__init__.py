"""Launches and their outcomes.

Starts, runs with their neighbours, what a launch settles on, the dataset with its observables.
May import `boundary` and the floors below.
To add an outcome: a member of `Outcome` in `result.py`, and what ends so in `OF_END`.
To add an observable: an expression in `observables` of the body's `System`, its name in
`observables.py` and `dataset.py`.
"""
