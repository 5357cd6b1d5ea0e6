"""The atlas: diagrams on a page.

Diagrams and loci of the families for three bodies.
May import `figures`, `tables` and the floors below.
To add a body or a range: an entry in `BODIES` or `RANGES` of `page.py`.
"""
