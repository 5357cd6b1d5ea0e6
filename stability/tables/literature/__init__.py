"""Tables about the disk of papers: circular rolling, thresholds, and the end of a spun disk.

Known values are from a formula or a number of the source that was at hand; where it was not, the
row says so.  May import the public functions of the package and `benchmarks.row`.  To add a table:
a module with a `Definition` named `TABLE`, and its name in `PLACES` of `tables/contents/places.py`.
"""
