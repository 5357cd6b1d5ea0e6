"""Bodies that roll, contact laws.

`model.py` has the record that a launch needs of a body.  `thin_disk` has the disk.
May import `systems`, `jobs` and the floors below.
To add a contact law: a subclass of `Contact` in `contact_laws.py`.
To add a family: a `SteadyFamily` in `bodies/families.py`.
To add a body: a folder like `thin_disk`, with a module for its `System`, one for its families, and,
where the characteristic polynomial is known, a subclass of `ExactPolynomial`.
"""
