"""What the documentation site adds to Sphinx: commands that run, figures that are made, reference."""
