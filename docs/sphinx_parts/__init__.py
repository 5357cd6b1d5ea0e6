"""What the documentation site adds to Sphinx: commands, figures, the reference."""
