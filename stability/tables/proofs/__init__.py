"""Tables of proofs: theorems, and the completeness of the families.

Steps as they were checked, as text and LaTeX.  May import `derivation`, `tables/formats`.
To add one: a module with a `Definition` like `theorems.py`, and its name in `PLACES` of
`tables/registry.py`.
"""
