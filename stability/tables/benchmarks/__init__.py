"""Systems with known answers, asked again: published thresholds, spectra, coefficients, periods.

Each module holds a few systems, as a user would write them, and returns their rows.  May import the
public names of the package and the floors below `tables`.  To add a row: a call of `compared` or
`threshold` in the module of its system; to add a system: a function in a module, and its entry in
`CASES` of `catalogue.py`.
"""
