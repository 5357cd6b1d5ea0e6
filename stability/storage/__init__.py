"""Files that are whole, or not there.

Datasets in the format of their ending, finished pieces of work, stores of chunks; checksums, JSON,
CSV, the frame of HTML pages, names of files to write.  May import `base` only.
To add a format of datasets: a module like `netcdf.py`, and its record in `FORMATS` of `formats.py`.
To add one of figures: its ending in `PICTURES` of `targets.py`, its `_KINDS` of `origin.py`.
To add a store of finished pieces: the functions of `pieces.Pieces`; of chunks: those of
`chunks.Store`.
Each file is written through `atomic_write` of `files.py`.
"""
