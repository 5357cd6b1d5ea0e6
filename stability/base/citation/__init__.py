"""What to cite: works, and the choice among them by what a call has used.

May import `base`.
To add a work: an entry of `WORKS` in `works.py`, and its key where it is used in `used.py`.
"""
