"""Further routes to a spectrum, for systems that the usual route does not serve.

`numeric` judges a Python function, which has no graph, by a numerical derivative.
Nothing here imports `spectrum` or `certificate`, which call these routes.
To add a route: write one module, and call it where the usual route does not serve.
"""
