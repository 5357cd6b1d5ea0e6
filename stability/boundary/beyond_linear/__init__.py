"""What linear theory leaves open at a boundary: soft or hard onset, and points of codimension two.

`derivatives` reads second and third derivatives of a graph in balls, `krawczyk` proves solutions,
`crossings_proved` the crossing of a pair, `first_coefficient` its first Lyapunov coefficient or the
normal form of a line, `births` goes along an axis; `points` and `vanishing` find what meets at
single points of a parameter plane, from `coefficients` and `systems_of_two`.
May import what `boundary` may, and its `changes`, `crossings` and `interval_search`.
To add a kind of point: a `PointKind`, and its equations in `systems_of_two`.
"""
