"""Theorems about the disk, each a list of computed steps.

`catalogue` lists the theorems, `motion` holds the equations from the graph, `signs` proofs of
signs, `flutter` what spinning and tumbling share; every other module proves a theorem.  The form of
a theorem is in `proof`, next to this folder.  May import the modules of `derivation`.
To add a theorem: a module with a function that returns a `Theorem`, and its entry in `PROOFS` of
`catalogue`.
"""
