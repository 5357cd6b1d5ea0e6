"""Routes to eigenvalues, compared."""
