"""Work in pieces, kept and resumed.

Ordered work over any executor, copies for its workers, processes that may fail, checkpoints, the
journal of a comparison; stores of arrays in chunks, which workers fill.
May import `storage`, `algebra` and `base`.
To add a kind of worker: any `concurrent.futures.Executor`, given to `pipeline.ordered`, and a word
for it in `dask.engine`.
To add a store of finished pieces: the three functions of `pipeline.Keep`.
To add a store of chunks: those of `chunks.Store`.
"""
