"""Number types, polynomials, bounds.

`Program` runs a CasADi graph in any number type: doubles with bounds, balls, exact numbers, SymPy.
May import `base` only.
To add a number type: an `Algebra` in `number_types.py`, a table of functions by name; `Program.run`
then reads every graph in this type.
To add a kernel: a module of plain functions, compiled by those of the folder `kernels`.
To add an eigensolver: a function of matrices, given to `eigensolver` in `eigensolver.py`.
"""
