"""Work in pieces, kept and resumed.

Ordered work over an executor, processes that may fail, checkpoints, the journal of a comparison.
May import `storage`, `algebra` and `base`.
To add a kind of worker: any `concurrent.futures.Executor`, given to `pipeline.in_order`.
"""
