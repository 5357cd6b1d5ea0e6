"""Bodies that roll, contact laws.

The disk: its equations, families and polynomials; the laws of contact.
May import `systems`, `jobs` and the floors below.
To add a contact law: a subclass of `Contact` in `contact.py`.
To add a family of the disk: a `DiskFamily` in `disk_families.py`.
To add a body: a module that returns its `System` (as `disk_equations.py`), and one that returns its
families, each a `Family` (as `disk_families.py`).  Where its characteristic polynomial is known, a
subclass of `ExactPolynomial` (as `DiskPolynomial` in `disk_polynomials.py`).
"""
