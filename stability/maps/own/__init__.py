"""Maps of your own families: exact conditions over two axes, and growth rates of any graph.

Up to here a map asks `slices` for the family's polynomial over Q in its axes.  A new way to decide
cells goes in a module of its own; it may import the exact algebra and the spectra, no body.
"""
