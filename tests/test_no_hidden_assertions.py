"""Every assertion of the tests runs: what finds those that may not is tried on planted ones, then on all tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import SLOWEST
from tests.counting import Share, some
from tests.hidden_assertions import hidden_assertions
from tests.silent_tests import silent_tests

HERE = Path(__file__).parent
# The helper itself: its assertions are what the others' are held to.
EXEMPT = {"counting.py"}

SEEN = {
    "a plain one": "def test():\n    assert x",
    "a loop over a literal": "for i in (1, 2):\n    assert x",
    "a loop over a range": "for i in range(1, 4):\n    assert x",
    "a loop over what was counted": "for i, j in some(zip(a, b)):\n    assert x",
    "a loop over a named literal": "NAMES = ['a']\ndef test():\n    for name in sorted(NAMES):\n        assert x",
    "a loop over pairs with a literal": "for i, j in zip(found, (1, 2), strict=True):\n    assert x",
    "a counted condition": "if a:\n    share.asserted()\n    assert x",
    "a counted way past an exit": "for i in (1,):\n    if a:\n        continue\n    share.asserted()\n    assert x",
    "an exit of a loop that is over": "for i in found:\n    if i:\n        break\nassert x",
    "all of what was counted": "assert all(i for i in some(found))",
    "any of what may be nothing": "assert any(i for i in found)",
    "try without a handler": "try:\n    assert x\nfinally:\n    y()",
    "behind pytest.raises": "with pytest.raises(E):\n    f()\nassert x",
}
HIDDEN = {
    "a condition": "if a:\n    assert x",
    "the other side of a condition": "if a:\n    pass\nelse:\n    assert x",
    "a condition in a loop": "for i in (1, 2):\n    if i == 3:\n        assert x",
    "an exit before": "def test():\n    if a:\n        return\n    assert x",
    "an exit of an exception": "def test():\n    try:\n        f()\n    except E:\n        return\n    assert x",
    "a skipped round of a loop": "for i in (1, 2):\n    if a:\n        continue\n    assert x",
    "an exception": "try:\n    f()\nexcept E:\n    assert x",
    "no exception": "try:\n    f()\nexcept E:\n    pass\nelse:\n    assert x",
    "a caught failure": "try:\n    assert x\nexcept E:\n    pass",
    "a loop over anything": "for i in found:\n    assert x",
    "a loop over an empty literal": "for i in ():\n    assert x",
    "a loop over a range of unknown length": "for i in range(n):\n    assert x",
    "a loop while a condition holds": "while a:\n    assert x",
    "a case of a match": "match a:\n    case 1:\n        assert x",
    "all of anything": "assert all(i for i in found)",
    "not any of anything": "assert not any(i for i in found)",
    "a filtered literal": "for i in [j for j in (1, 2) if j > 2]:\n    assert x",
    "inside pytest.raises": "with pytest.raises(E):\n    f()\n    assert x",
    "numpy's own": "if a:\n    np.testing.assert_allclose(x, y)",
    "an exception that is expected": "if a:\n    with pytest.raises(E):\n        f()",
}


@pytest.mark.parametrize("name", SEEN)
def test_an_assertion_that_runs_is_left_alone(name):
    assert hidden_assertions(SEEN[name]) == []


@pytest.mark.parametrize("name", HIDDEN)
def test_a_hidden_assertion_is_found(name):
    assert len(hidden_assertions(HIDDEN[name])) == 1


def test_no_test_hides_an_assertion():
    """What to do: loop over `tests.counting.some(...)`, count with a `Share`, or make two tests of it."""
    files = some((path for path in sorted(HERE.rglob("*.py")) if path.name not in EXEMPT), least=150)
    found = [
        f"{path.relative_to(HERE)}:{hidden.line}: {hidden.why}"
        for path in files
        for hidden in hidden_assertions(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_a_share_holds_its_tests_to_what_they_state():
    with Share(0.5) as share:
        for number in range(4):
            share.case()
            if number % 2:
                share.asserted()
                assert number > 0
    assert (share.cases, share.reached) == (4, 2)


@pytest.mark.parametrize(("cases", "words"), [(0, "no case was tried"), (3, "asserted in 1 of 3 cases")])
def test_a_share_that_is_not_reached_fails(cases, words):
    share = Share(0.5)
    share.cases, share.reached = cases, min(cases, 1)
    with pytest.raises(AssertionError, match=words), share:
        pass


def test_what_fails_inside_a_share_is_what_is_told():
    with pytest.raises(ValueError, match="the true reason"), Share(1.0):
        raise ValueError("the true reason")


@pytest.mark.parametrize("least", [0.0, -1.0, 1.1])
def test_a_share_that_says_nothing_is_refused(least):
    with pytest.raises(AssertionError, match="says nothing"):
        Share(least)


def test_some_are_as_many_as_stated():
    assert some(iter("ab")) == ["a", "b"]
    assert some({"a": 1}.items(), least=1) == [("a", 1)]
    with pytest.raises(AssertionError, match="0 things to look at"):
        some([])
    with pytest.raises(AssertionError, match="expected 3 at least"):
        some("ab", least=3)


def test_the_slowest_files_are_there():
    assert [name for name in some(SLOWEST) if not (HERE / name).is_file()] == []


def test_every_test_asserts_something():
    planted = {
        "a.py": "def test_a():\n    f()\ndef test_b():\n    g()\ndef test_c():\n    assert x",
        "b.py": "def f():\n    h()\ndef h():\n    np.testing.assert_equal(1, 1)\ndef g():\n    pass",
    }
    assert silent_tests(planted) == ["a.py: test_b"]
    paths = some(HERE.rglob("*.py"), least=150)
    assert silent_tests({str(path): path.read_text(encoding="utf-8") for path in paths}) == []
