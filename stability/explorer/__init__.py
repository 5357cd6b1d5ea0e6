"""Diagrams alive in a browser.

`explore.py` holds the public function.  `round_page.py` and `system_page.py` say which
families a page has; each is a `PageSubject` (`subject.py`): a `Family` with its numbers.  Its
formulas (`formulas.py`, `verdicts.py`) become JavaScript (`source.py`);
`page.py` joins `script/` and data.  May import `atlas`, `compare` and the floors below.
To add what a page tells of a family: `subject.py`, and a module in `script/` that shows it.
To add a way to decide a verdict: a function in `verdicts.py` that gives one `PageFormulas`.
"""
