"""The box about a state in which its motion converges.

May import `stability.settling.surroundings` and what that imports.
`alone.py` has the proof and tries one launch in flint's balls, `together.py` many in balls of
doubles by the compiled loops of `kernel.py`.
To add a basis in which boxes are tried: a line in both.
"""
