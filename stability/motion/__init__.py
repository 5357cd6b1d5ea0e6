"""Launches and their outcomes.

Starts with what moves, runs with their neighbours, outcomes, the dataset with its observables.
May import `boundary`, `settling` and the floors below.
To add an outcome: a member of `Outcome` in `result.py`, and its kind of end in `OF_END`.
To add an observable of a body: `series` in `bodies/round_body/models/`, `bodies/quantities.py`.
"""
