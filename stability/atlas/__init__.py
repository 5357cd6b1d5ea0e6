"""The main job: diagrams and loci of three families for three bodies, with a page."""
