"""Further routes to a spectrum: for large systems, and for systems that have no graph.

`numeric` judges a Python function by a numerical derivative, `large` proves the spectrum of many
states from approximate eigenvectors in balls.
Nothing here imports `spectrum` or `certificate`, which call these routes.
To add a route: write one module, and call it where the usual route does not serve.
"""
