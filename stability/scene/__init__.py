"""Scenes: the least model that answers a question, with evidence.

A scene (`scene.py`) holds the question.  `ladder.py` tries the rungs of `rungs/` in the order of
their cost and takes the first whose estimated error is below the tolerance.  A rung is one file:
a function of a `Problem` that returns a `Track`, or the reason why there is none.  It imports
`motion`, `maps` and all below; figures and commands import it.
"""
