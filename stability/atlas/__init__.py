"""The atlas: diagrams on a page.

Diagrams and loci of the families for three bodies.
May import `figures`, `scene`, `tables` and the floors below.
To add a body: an entry in `BODIES` of `page.py`.
To add a family: the interval `drawn` in its record of `bodies/thin_disk/disk_families.py`.
"""
