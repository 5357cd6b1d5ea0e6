"""Settings of executed cells: sharp figures on a white ground, without the user's own settings."""

c = get_config()  # noqa: F821
c.InlineBackend.figure_formats = {"retina"}
c.InlineBackend.rc = {"figure.dpi": 110}
c.HistoryManager.enabled = False
c.IPKernelApp.log_level = 50
