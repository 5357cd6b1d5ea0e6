"""The way into Node and back, by which the other tests ask the page's scripts."""

import math

import pytest
from node import Engine


def test_numbers_are_the_same_there_and_back(disk: Engine) -> None:
    given = [0.1, -0.0, 5e-324, 1.7976931348623157e308, math.inf, -math.inf, 2**53, -1 / 3]
    found = disk.evaluate("(v) => v", given)
    assert [float(v).hex() for v in found] == [float(v).hex() for v in given]
    assert math.isnan(disk.evaluate("({v}) => v", {"v": math.nan}))
    assert disk.evaluate("(v) => v[0] === Infinity && Number.isNaN(v[1])", [math.inf, math.nan])


def test_arrays_texts_and_nothing_are_the_same_there_and_back(disk: Engine) -> None:
    assert disk.evaluate("new Float64Array([0.1, NaN, -0])")[0::2] == [0.1, 0.0]
    assert disk.evaluate("(v) => v", {"φ̇": ["−1·10⁻⁴", None, True]}) == {
        "φ̇": ["−1·10⁻⁴", None, True]
    }
    assert disk.evaluate("undefined") is None


def test_an_exception_of_the_script_is_one_of_the_test(disk: Engine) -> None:
    with pytest.raises(AssertionError, match="TypeError"):
        disk.evaluate("() => null.missing")
    assert disk.evaluate("1 + 1") == 2  # and the next question is answered
