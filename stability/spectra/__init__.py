"""Eigenvalues with error discs, and verdicts.  Imports `systems`; some files `bodies`."""
