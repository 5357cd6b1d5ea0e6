"""Settling: the steady motion nearest to a state, and the proof that a motion converges to it.

`attraction.py` is the proof, `disk_settling.py` the disk's members in closed form,
`system_settling.py` those of any `Family`.  May import `bodies` and the floors below.
To have a body settle on its families: a class with the two methods of `nearest.Settling`.
"""
