"""Where a system's equations come from, besides CasADi expressions: other tools and functions.

`sympy_models` reads what SymPy's mechanics makes, `casadi_functions` reads CasADi functions and
files, and `numeric` takes a plain Python function, of which no proof is possible.
Nothing here imports `System`: each source returns keyword arguments, and the classmethods of
`stability.systems.system.System` build the instance.
To add a source: write one module with a function that returns such keyword arguments.
"""
