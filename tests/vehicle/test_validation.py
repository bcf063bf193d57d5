"""The validation page: our numbers differ from others' by no more than they may, and the page has what is computed."""

from functools import cache

import pytest
from validation import PAGE, marks
from validation_cases import TABLES, WITH_FILES, Line, Quantity, Table

TEXT = PAGE.read_text(encoding="utf-8")


def on_page(name: str) -> str:
    begin, end = marks(name)
    assert TEXT.count(begin) == TEXT.count(end) == 1
    return TEXT.partition(begin)[2].partition(end)[0]


@cache
def computed(name: str) -> Table:
    return TABLES[name]()


@pytest.mark.parametrize("name", TABLES)
def test_our_numbers_are_theirs(name: str) -> None:
    assert computed(name).misses() == []


@pytest.mark.parametrize("name", TABLES)
def test_the_page_has_the_numbers_that_are_computed(name: str) -> None:
    assert on_page(name) == computed(name).markdown()


@pytest.mark.parametrize("name", WITH_FILES)
def test_tables_of_files_are_on_the_page(name: str) -> None:
    assert on_page(name).startswith("Theirs: ")
    assert on_page(name).count("\n|") > 5


def test_a_difference_that_is_too_large_is_said() -> None:
    table = Table("nobody", (Quantity("place, mm", ".2f", 0.1), Quantity("rate", ".3f", 0.01, relative=True)),
                  (Line("near", ((1.0, 1.05), (2.0, 2.01))), Line("far", ((1.0, 1.2), (2.0, 2.1)), (0.1, 0.1))))  # fmt: skip
    assert table.misses() == ["far: place, mm must be 1.20 within 0.1, got 1.00"]
    assert "| near | 1.00 | 1.05 | -0.05 | 2.000 | 2.010 | -0.50 % |" in table.markdown()
