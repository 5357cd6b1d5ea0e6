"""What is read from a system's graph: at a family, with slopes, and on which states it depends.

`family_graph` reads a system at a family, `slopes` folds the slopes of a large graph on the way,
`ignorable` finds states that nothing else depends on, and `implicit_form` solves the one equation
of formulas in an unknown.  May import `algebra`, `base` and the
record of equations.
To add something read from the graph: write one module with a function of `Equations`.
"""
