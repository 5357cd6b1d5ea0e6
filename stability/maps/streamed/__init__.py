"""Maps that go to their file in parts: who computes a part, and what it is written to.

`verdicts` judges bands of a map, `netcdf_file` writes them in order, and `zarr_folder` has workers
write whole chunks of verdicts or of growth rates.
May import `boundary`, `settling` and the floors below, and `maps`.
To add a variable of a streamed map: `cell_attributes` of `maps/dataset.py`, and its array in
`GrowthChunk` of `zarr_folder.py`.
"""
