"""Commands that hand results on: `export`, `cite`.

May import the public functions, `cli/options.py` and the floors below.
To add one: a module like `export.py`, and a call of `command` in `cli/commands.py`.
"""
