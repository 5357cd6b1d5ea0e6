"""Bodies that roll, contact laws.

`round_body` has every body of revolution, the thin disk as one of them; `thin_disk.py` has the
disk's public calls.  `model.py` has the record that a launch needs of a body.
May import `polynomials` and the floors below.
To add a contact law: a subclass of `Contact` in `contact_laws.py`.
To add a family: a `SteadyFamily` in `bodies/families.py`.
To add a body: a function in `round_body/shapes/named.py` that returns a `Body`.
"""
