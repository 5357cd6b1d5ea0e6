"""What rolls: the disk, its laws, equations, families, polynomials.  Imports `systems`."""
