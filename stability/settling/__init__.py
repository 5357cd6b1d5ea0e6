"""Convergence to steady motions.

`settling.py` says which states have settled: it tries a tube (`tube.py`), then a box (`box.py`),
from the equations near a family (`surroundings.py`).  Bodies and systems differ by their families
alone: a `FamilyLine` (`line.py`) of each, from `body_lines.py` and `system_lines.py`.
May import `spectra`, `derivation`, `integrators` and the floors below.
To add what motions settle on: a `FamilyLine` for each family; a basis of boxes: a line in
`attraction` and in `boxes`; a term of a tube: a field of `Form` and `NormalFormBounds`, and its
part in `tube.py`.
"""
