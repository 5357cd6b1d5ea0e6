"""Work in pieces, kept and resumed.

Ordered work over any executor, copies for its workers, processes that may fail, stores that workers
fill, measured cells of a comparison.  May import `storage`, `algebra` and `base`.
To add a kind of worker: any `concurrent.futures.Executor`, given to `pipeline.ordered`, and a word
for it in `dask.engine`.
"""
