"""The thin disk: equations, families of steady motions, exact polynomials, units.

May import what `bodies` may.
To add a family: a `DiskFamily` in `bodies/thin_disk/disk_families.py`.
"""
