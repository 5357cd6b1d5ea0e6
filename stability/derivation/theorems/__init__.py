"""Theorems about the disk, each a list of computed steps.

`catalogue` lists the theorems, `record` holds their form, `motion` the equations from the graph,
`signs` the proofs of signs; every other module proves one theorem.  May import the modules of
`derivation` next to this folder.
To add a theorem: a module with a function that returns a `Theorem`, and its entry in `PROOFS` of
`catalogue`.
"""
