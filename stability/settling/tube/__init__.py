"""A tube about a line of steady motions in which every motion is proved to converge to the line.

`derivatives.py` has the graphs, `normal_form.py` the coordinates in which terms of second order
vanish, and their bounds, `radius.py` the inequality, `nodes.py` the members that launches share.
May import `stability.settling.surroundings` and what that imports.
To add a term to the coordinates: a field of `Form` and of `Bounds`, and its part in `radius.py`.
"""
