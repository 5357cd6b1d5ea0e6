"""Points of a parameter plane at which two conditions meet, each proved.

`points` is the way in; `planes` gives the polynomial over the plane and the equations of each kind,
`plane_search` their solutions, `bautin` the points where the first Lyapunov coefficient vanishes,
and `point_records` the result.
May import what `boundary` may, and its `changes`, `hopf` and `interval_search`.
To add a kind of point: a `PointKind`, and its equations in `planes`.
"""
