"""The table of thresholds, and the list of tables: what may be called what."""

import json
from functools import cache
from typing import Any

import pytest

import stability as st
from stability.cli.commands import main
from stability.tables.benchmarks.catalogue import CASES
from stability.tables.benchmarks.row import AGREES, CLOSED, PUBLISHED, QUOTED
from stability.tables.registry import PLACES, definition, every_table
from stability.tables.table import Standing


@cache
def rows() -> list[dict[str, Any]]:
    return list(st.table("thresholds"))


# --- the list ---


def test_every_table_says_where_it_is_from() -> None:
    said = {row["name"]: row for row in every_table()}
    assert set(said) == {*PLACES, "codimension"} - {"list"}
    for row in said.values():
        assert all(
            len(row[key]) >= 8 for key in ("source", "published", "recomputed", "difference")
        )
        assert Standing(row["status"].split(":")[0])


def test_nothing_is_reproduced_whose_printed_value_was_not_at_hand() -> None:
    """The standing follows from the rows: none of them was published."""
    assert {row["origin"] for row in rows()} == {QUOTED, CLOSED}
    about = definition("thresholds").about
    assert about is not None
    assert about.standing is Standing.RECOMPUTED


def test_no_table_without_published_rows_is_called_reproduced() -> None:
    for name in PLACES:
        about = definition(name).about
        if name not in ("list", "benchmarks", "thresholds", "peers"):
            assert about is not None
            assert about.standing in (Standing.RECOMPUTED, Standing.DERIVED), name


def largest(table: Any) -> float:
    """The largest difference relative to the known value."""
    return max(abs(r["difference"] / float(r["known"])) for r in table if float(r["known"]))


def test_the_stated_difference_is_the_largest() -> None:
    about = definition("thresholds").about
    assert about is not None and about.largest is not None
    assert about.largest / 5 < largest(rows()) <= about.largest


@pytest.mark.long
def test_the_stated_difference_of_the_benchmarks_is_the_largest() -> None:
    about = definition("benchmarks").about
    assert about is not None and about.largest is not None
    found = [row for row in st.table("benchmarks", systems=list(CASES)) if row["recomputed"]]
    assert about.largest / 5 < largest(found) <= about.largest
    assert {row["origin"] for row in found} > {PUBLISHED, CLOSED}
    assert about.standing is Standing.PARTLY


def test_the_command_lists_the_tables(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["table", "--list", "--json"]) == 0
    body = json.loads(capsys.readouterr().out)
    names = [column["name"] for column in body["columns"]]
    assert names[2:] == ["source", "published", "recomputed", "difference", "status"]
    assert [row["name"] for row in body["rows"]] == [row["name"] for row in st.table("list")]
    assert main(["table", "--list"]) == 0
    text = capsys.readouterr().out
    assert main(["table", "list"]) == 0
    assert capsys.readouterr().out == text
    assert "reproduced in part: " in text


@pytest.mark.parametrize("words", [[], ["drift", "--list"]])
def test_a_name_or_the_list_is_asked_for(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["table", *words]) == 2
    assert "give the name of a table, or --list" in capsys.readouterr().err


def test_all_known_values_agree() -> None:
    for row in rows():
        assert row["status"] == AGREES, row


def test_a_wrong_known_value_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The report's spin with another last digit disagrees."""
    from stability.tables import thresholds

    monkeypatch.setattr(thresholds, "SPIN", "-4.6852")
    [row] = thresholds._relative_spin()
    assert row.status == "agrees to 4 digits of 5"
