"""Points of a parameter plane at which two conditions meet, each proved.

`points` is the way in; `planes` gives the polynomial over the plane, `systems_of_two` the equations
of each kind, `plane_search` their solutions, `vanishing` changes of sign of the first coefficient,
and `point_records` the result.
May import what `boundary` may, and the modules of `beyond_linear`.
To add a kind of point: a `PointKind`, and its equations in `systems_of_two`.
"""
