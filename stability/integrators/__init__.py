"""A leg of a motion in, its path out; one file for each family of methods."""
