"""Launches and what becomes of them."""
