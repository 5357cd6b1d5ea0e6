"""The thin disk: equations, exact polynomials, units.

May import what `bodies` may.
To add a quantity of the disk: its `Quantity` in `bodies/thin_disk/disk_quantities.py`.
"""
