"""Any system, any family of steady motions.  Imports `algebra`."""
