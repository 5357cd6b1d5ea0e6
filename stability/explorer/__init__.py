"""Diagrams alive in a browser.

`explore.py` holds the public function.  Polynomials and graphs become JavaScript and shader source
(`source/`), a family becomes one record of the page (`disk_subjects.py`,
`own_subject.py`), and `page.py` joins the modules of `script/` into one file.
May import `atlas`, `compare` and the floors below.
To add something to the page: a module in `script/`, imported by another one there.
"""
