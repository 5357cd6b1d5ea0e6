"""The least model that answers.

A scene (`scene.py`) holds the question.  `ladder.py` tries the rungs of `rungs/`, cheapest first,
and takes the first whose estimated error is below the tolerance.
May import `maps`, `motion` and the floors below.
To add a rung: a file in `rungs/`, and its place in `climb` of `ladder.py`.
To add a quantity: one `Question` in `_EVERY` of `questions.py`; of a steady motion one
`LinearQuestion` in that of `linear.py`.
"""
