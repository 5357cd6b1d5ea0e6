"""The atlas: diagrams on a page.

Diagrams and loci of the families for three bodies, and diagrams for bodies of revolution.
May import `figures`, `tables`, `export` and the floors below.
To add a body: an entry in `BODIES` of `page.py`; of revolution, in `BODIES` of `bodies.py`.
To add a family: the interval `drawn` in its record of `bodies/families.py`.
"""
