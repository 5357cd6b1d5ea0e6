"""Theorems about the thin disk alone, h = sinθ, and what the general ones say of it.

`case` puts the height in; `settling`, `flutter`, `tumbling`, `boundary_shape` and `dry_friction`
prove what is known of this body only.
"""
