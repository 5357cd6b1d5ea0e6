"""A spectrum for a reader: text, HTML, and a labelled dataset with units and provenance.

May import what `spectra` may, and nothing of `spectra` itself: a spectrum comes as an argument.
To add a form: one more module here, and one method of `Spectrum` that calls it.
"""
