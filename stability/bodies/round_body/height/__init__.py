"""Heights as graphs: kept as text, read by cos θ and sin θ, and proved convex.

May import what `bodies` may, and nothing else of `round_body`.
To add a way to read a height: a module here.
"""
