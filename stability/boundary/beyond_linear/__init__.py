"""What linear theory leaves open at a boundary: soft or hard onset, and points of codimension two.

`derivatives` reads second and third derivatives of a graph in balls, `krawczyk` proves solutions,
`crossings_proved` the crossing of a pair, `first_coefficient` its first Lyapunov coefficient or the
normal form of a line, and `births` goes along an axis.  `two_parameters` goes over a plane.
May import what `boundary` may, and its `changes`, `crossings` and `interval_search`.
To add a normal form: a function of a `Pair` in `first_coefficient`.
"""
