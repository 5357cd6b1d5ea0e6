"""Exact statements about a body of revolution whose axis is vertical.

`graph` reads the chart around a pole in SymPy; `polynomials` derives complex polynomials from it;
`vertical` and `steady` prove theorems.
"""
