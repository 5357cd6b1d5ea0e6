"""Files that are whole or not there: names, checksums, NetCDF, JSON.  Imports `base`."""
