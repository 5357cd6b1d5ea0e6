"""Convergence to steady motions.

`settling.py` says which states have settled, for one launch or many: it tries a tube
(`tube.py`), then a box (`box.py`), from the equations near a family (`surroundings.py`).  Bodies
and systems differ by their families alone: a `Line` (`line.py`) of each, from `body_lines.py` and
`system_lines.py`; `fixed_axes.py` reads states along fixed axes.
May import `spectra`, `derivation`, `integrators` and the floors below.
To add what motions settle on: a `Line` for each family.
To add a basis in which boxes are tried: a line in `attraction` and one in `boxes`.
To add a term to the coordinates of a tube: a field of `Form` and of `Bounds` in `normal_form.py`,
and its part in `tube.py`.
"""
