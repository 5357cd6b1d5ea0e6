"""What is read from a system's graph: at a family, with slopes, and on which states it depends.

`family_graph` reads a system at a family, with the slopes of a large graph folded on the way,
`ignorable` finds states that nothing else depends on, `smoothness` what has no slope, `constants`
keeps numbers from being rounded.  May import `algebra`, `base` and the record of equations.
To add something read from the graph: write one module with a function of `Equations`.
"""
