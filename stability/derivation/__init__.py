"""SymPy at work, offline: exact polynomials, conditions, formulas, proofs of completeness."""
