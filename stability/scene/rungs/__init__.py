"""The models of a scene, one file each.

`track.py` has the problem without units and the track, which is samples with their errors.
`near_steady.py` has steady and linear motion, `creep.py` and `creeping.py` creep, `reduced.py` a
user's reduced model, `full.py` the law itself.
To add a rung: a function of a `Problem` that returns a `Track` with its errors, or `Refused` with
the reason.  `scene/ladder.py` calls it.
"""
