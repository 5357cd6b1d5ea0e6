"""Bodies of revolution from their surfaces.

May import what `bodies` may.
To add a body by its meridian: a function in `bodies/round_body/shapes/profile.py`.
"""
