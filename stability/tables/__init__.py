"""Registered tables, and their text, Markdown, LaTeX and JSON."""
