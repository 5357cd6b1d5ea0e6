"""A leg in, a path out.

A `Leg` is a flow, a start, times and a tolerance; a `Path` is the states at these times.
`lanes` runs many launches at once, for motions and for maps of outcomes.
May import `bodies` and the floors below.
To add an integrator: its `Integrator` in `INTEGRATORS` of its own module, and its name in `PLACES`
of `registry.py`.
"""
