"""Every slow test names a faster one of its kind, which `make test` runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.conftest import check_beside

SLOW = pytest.mark.slow.mark
FAST_TESTS = ("tests/a/test_b.py::test_left", "tests/a/test_c.py::test_left")


class Item:
    """A stand-in for a collected test, with the node id and marks that `check_beside` reads."""

    def __init__(self, nodeid: str, *marks: pytest.Mark) -> None:
        self.nodeid, self.marks = nodeid, marks

    def iter_markers(self, name: str) -> list[pytest.Mark]:
        return [mark for mark in self.marks if mark.name == name]

    def get_closest_marker(self, name: str) -> pytest.Mark | None:
        return next(iter(self.iter_markers(name)), None)


def check(*items: Item, root: Path = Path()) -> None:
    collected: Any = [*map(Item, FAST_TESTS), *items]
    check_beside(collected, root)


def slow(beside: str, test: str = "tests/a/test_b.py::test_slow") -> Item:
    return Item(test, pytest.mark.slow(beside=beside).mark)


def test_a_test_that_is_left_may_be_named_from_near_and_far(tmp_path: Path) -> None:
    for beside in ("test_left", "test_c.py::test_left", FAST_TESTS[1]):
        check(slow(beside))
    check(Item("tests/a/test_b.py::test_some[1]"), Item("tests/a/test_b.py::test_some[2]", SLOW))
    (tmp_path / "tests/d").mkdir(parents=True)
    (tmp_path / "tests/d/test_e.py").touch()  # not collected
    check(slow("tests/d/test_e.py::test_left"), root=tmp_path)


@pytest.mark.parametrize(
    ("items", "message"),
    [
        ([Item("tests/a/test_b.py::test_slow", SLOW)], "test_slow is slow and names no"),
        ([Item(f"tests/a/test_b.py::test_all[{k}]", SLOW) for k in "12"], "test_all is slow and n"),
        ([slow("tests/d/test_e.py::test_left")], "beside 'tests/d/test_e.py::test_left', which"),
        ([slow("test_gone")], "test_slow is slow beside 'test_gone', which is"),
        ([slow("test_slow")], "beside 'test_slow', which is"),
        (
            [slow("test_seen"), Item("tests/a/test_b.py::test_seen", pytest.mark.browser.mark)],
            "beside 'test_seen', which is",
        ),
    ],
    ids=["without a name", "all cases", "no file", "no test", "a slow one", "one of the browser"],
)
def test_what_names_no_test_that_is_left_is_refused(items: list[Item], message: str) -> None:
    with pytest.raises(pytest.UsageError, match=message):
        check(*items)
