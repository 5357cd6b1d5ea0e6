"""Datasets to figures and films; matplotlib is imported here and above only."""
