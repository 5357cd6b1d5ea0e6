"""Integrators, compared."""
