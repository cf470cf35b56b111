"""Tables of bad input, by subject: each call is refused with one message."""

import pytest

import galvi
from tests.users.refusals import groups, methods, models, runs, systems

ROWS = [
    pytest.param(*row[:2], row[2:], id=f"{subject}: {number}")
    for table in (systems, groups, methods, runs, models)
    for subject, rows in table.TABLE.items()
    for number, row in enumerate(rows, 1)
]


@pytest.mark.parametrize(("error", "message", "call"), ROWS)
def test_bad_input_is_answered_in_one_sentence(error, message, call):
    """A row has the error, a pattern of its message, a function and its arguments."""
    function, *arguments = call
    with pytest.raises(error, match=message) as refusal:
        function(*arguments)
    assert str(refusal.value).rstrip().endswith((".", ")"))


def test_what_is_no_model_of_mujoco_is_answered_in_one_sentence():
    for error, message, function, *arguments in models.mujoco():
        with pytest.raises(error, match=message):
            function(*arguments)


@pytest.mark.parametrize(
    ("name", "meant"),
    [("Gauss", "gauss"), ("Lobatto", "lobatto"), ("kepler", "problems.kepler"), ("nbody", "NBody")],
)
def test_a_name_in_another_case_has_a_hint(name, meant):
    hint = rf"no attribute '{name}'. Did you mean galvi.{meant}\?"
    with pytest.raises(AttributeError, match=hint):
        getattr(galvi, name)
    assert not hasattr(galvi, "nothing_like_it")
