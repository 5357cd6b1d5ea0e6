"""Bodies of revolution in the page: families, motion in two charts, surface.

May import the rest of `explorer` but `explorer/explore.py`.
To add a family: its name in `body_page.py`; what its polynomial is made of, in `closed_subject.py`.
"""
