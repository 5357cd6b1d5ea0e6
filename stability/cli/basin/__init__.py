"""The command `basins`: many launches, and which one ends where.

May import what `cli` may.  `launched.py` reads the body, the law and the numbers that vary from
the options; `basins.py` runs the launches.
To add a kind of random number: a word in `launched.py`.
"""
