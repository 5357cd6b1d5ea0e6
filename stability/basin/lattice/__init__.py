"""Labels on a lattice of two axes that is refined where they differ.

`labels.py` checks a labelling function, `quadtree.py` cuts cells, `lines.py` joins their borders.
May import `base` alone.
To add a rule for refinement: `Tree.unlike`, which says which cells are cut.
"""
