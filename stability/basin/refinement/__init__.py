"""Borders of a map of launches: run wave by wave, kept, and written next to the map.

`waves.py` keeps the labels of each wave of launches, `arrays.py` makes the arrays of a dataset,
`sensitivity.py` those that say how sensitive a border is, `refine.py` joins all to a store.  May
import what `basin` may, and `lattice`, `statistics`, `borders` and `launch_labels`.
To add a number to borders: an array in `arrays.py`.
"""
