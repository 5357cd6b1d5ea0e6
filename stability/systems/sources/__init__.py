"""Where a system's equations come from, next to `mechanics`: SymPy, CasADi and plain functions.

Each module turns a model as its author writes it into the parts of a `System`: expressions, names,
observables, conditions.  Nothing here imports `System`: its classmethods build it.
May import the modules of `systems` that need no family, and lower floors.
To add a source: write one module with a function that returns these parts.
"""
