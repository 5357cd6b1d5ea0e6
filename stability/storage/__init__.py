"""Files that are whole, or not there.

Checksums, NetCDF, JSON, names of files to write.  May import `base` only.
To add a format: a module like `netcdf.py` with two functions, dataset to bytes and file to dataset,
and the endings of its files in `targets.py`.  Each file is written through `files.whole`.
"""
