"""Parameter grids of two axes.

Verdicts, growth rates and proved boxes over two parameters, as a dataset or streamed to a file.
`slices` reads the polynomial in the axes, `verdicts` decides by signs, `rates` finds growth rates
from coefficients, and `engine` joins them.
May import `boundary`, `settling` and the floors below.
To add a kind of family: a reader in `slices.py` that gives a `Slice`, or raises `NotExact`.
To add a variable of a map: its array in `Cells` of `cells.py`, its name and unit in
`cell_attributes` of `dataset.py`; of a streamed map also in `growth_of` of `stream.py`.
"""
