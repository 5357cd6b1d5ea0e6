"""Convergence to steady motions.

The steady motion nearest to a state, and the proof in ball arithmetic that a motion converges to
it: `proof.py` tries the tube of a member (`tube/`) and then a box about the state
(`attraction.py`); `disk_settling.py` has the members of the disk, `system_settling.py` those of any
`Family`.  `together/` has both proofs for many states at once.
May import `spectra`, `derivation`, `integrators` and the floors below.
To add a body: a class with the two methods of `Settling` in `nearest.py`.
"""
