"""Launches and their outcomes.

Starts, runs with their neighbours, outcomes, the dataset with its observables.
May import `boundary`, `settling` and the floors below.
To add an outcome: a member of `Outcome` in `result.py`, and its kind of end in `OF_END`.
To add an observable of the disk: its expression in `series` of `bodies/thin_disk.py`,
its name in `bodies/quantities.py`.
"""
