"""The command `explore`.

May import `explorer` and the floors below.
To add an option: `add_arguments` of `explore.py`.
"""
