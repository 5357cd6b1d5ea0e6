"""What decides a family's verdict: stored polynomials, a closed form, or conditions over Q.

May import `source`.  A new way gives one `Formulas`, which a page is built from.
"""
