"""Any system, any family of motions.

A `System` is equations of motion as one CasADi graph; a `Family` holds its steady motions, whose
unknowns `members` finds and follows up to the points of `singular_points`.
No body is known here.  May import `algebra`, `storage` and `base`.
To add a system: nothing is written here; make a `System` and a `Family`, as `bodies` does.
To add a computation for every family: write one module with a function of a `Family`.
"""
