"""Exact numbers: fields over Q, rational functions, isolated roots."""
