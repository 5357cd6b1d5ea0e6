"""The budget of exact work counts the work of its own thread."""

import threading
import time

import pytest
from flint import fmpq_mpoly_ctx

from stability.algebra.exact.hurwitz_forms import Budget, TooLarge


def busy(seconds: float) -> None:
    """Compute for so long."""
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def test_other_work_of_the_machine_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = time.monotonic
    budget = Budget(1000, 5.0)
    monkeypatch.setattr(time, "monotonic", lambda: plain() + 100.0)  # the process stood still
    assert budget.spent < 5.0
    budget.watch([1, 2, 3])


def test_own_work_counts() -> None:
    budget = Budget(1000, 0.05)
    budget.watch([1, 2, 3])
    busy(0.1)
    with pytest.raises(TooLarge, match=r"3 terms after 0\.\d s \(limits: 1000 terms, 0\.05 s\)"):
        budget.watch([1])


def test_another_thread_goes_by_the_wall_clock() -> None:
    budget, found = Budget(1000, 0.05), list[float]()
    time.sleep(0.1)
    other = threading.Thread(target=lambda: found.append(budget.spent))
    other.start()
    other.join()
    assert found[0] >= 0.1
    assert budget.spent < 0.05


def test_terms_are_limited() -> None:
    x, y = fmpq_mpoly_ctx.get(("x", "y"), "lex").gens()
    budget = Budget(4, 60.0)
    with pytest.raises(TooLarge):
        budget.product((1 + x) ** 2, (1 + y) ** 2)


def test_all_terms_together_are_limited() -> None:
    budget = Budget(4, 60.0, work=10)
    for _ in range(3):
        budget.watch([1, 2, 3])
    with pytest.raises(TooLarge):
        budget.watch([1, 2])


def test_a_determinant_of_high_degree_is_refused_before_it_is_computed() -> None:
    x, y = fmpq_mpoly_ctx.get(("x", "y"), "lex").gens()
    budget = Budget(1000, 60.0, degree=6)
    budget.expect(2, [x * y**2, x - x])
    with pytest.raises(TooLarge, match="degree beyond 6"):
        budget.expect(3, [x * y**2, x - x])
