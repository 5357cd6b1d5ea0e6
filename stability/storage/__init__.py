"""Files that are whole, or not there.

Checksums, NetCDF, JSON, CSV, the frame of HTML pages, names of files to write.
May import `base` only.
To add a format: a module like `netcdf.py` with a function from dataset to bytes (and back, where
the format is read), and its endings in `DATASETS` or `PICTURES` of `targets.py`.  Each file is
written through `atomic_write` of `files.py`.
"""
