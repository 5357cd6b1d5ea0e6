"""What decides a family's verdict: stored polynomials, a closed form, or conditions over Q.

May import `source` and `quantity` of `explorer`.
To add another way: a function that gives one `Formulas`, called where a page makes its subjects.
"""
