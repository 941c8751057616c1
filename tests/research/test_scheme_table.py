"""The table of schemes, and what a package outside adds to it."""

from __future__ import annotations

import sys

import pytest

import meshmark.research as research
from meshmark.errors import InputError

OUTSIDE = """
import numpy as np
from meshmark.research.schemes import Readout


class Toy:
    title, source, bits, blind = "Toy", "nowhere", 3, True

    def embed(self, mesh, bits, key, *, strength="standard"):
        return mesh

    def extract(self, mesh, key, *, reference=None):
        return Readout(np.zeros(3, np.uint8), False)


class Half:
    title = "Half a scheme"
"""
POINTS = "[meshmark.schemes]\ntoy = a_toy_scheme:Toy\nhalf = a_toy_scheme:Half\nncdg_lv = a_toy_scheme:Toy\n"


@pytest.fixture
def outside(tmp_path, monkeypatch):
    (tmp_path / "a_toy_scheme.py").write_text(OUTSIDE)
    package = tmp_path / "a_toy_scheme-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: a-toy-scheme\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text(POINTS)
    monkeypatch.syspath_prepend(tmp_path)
    yield
    sys.modules.pop("a_toy_scheme", None)


def test_our_own_scheme_is_there():
    assert "ncdg_lv" in research.SCHEMES
    assert research.SCHEMES["ncdg_lv"].bits == 64


def test_a_scheme_from_outside_joins(outside):
    assert {"ncdg_lv", "toy", "half"} <= set(research.SCHEMES)
    assert research.SCHEMES["toy"].title == "Toy"


def test_a_scheme_from_outside_cannot_take_our_name(outside):
    assert research.SCHEMES["ncdg_lv"].title == "NCDG-LV"
    assert list(research.SCHEMES).count("ncdg_lv") == 1


def test_half_a_scheme_is_refused(outside):
    with pytest.raises(InputError, match=r"'half' .* lacks source, bits, blind, embed, extract"):
        research.SCHEMES["half"]


def test_an_unknown_name_lists_the_valid_ones():
    assert "nonsense" not in research.SCHEMES
    with pytest.raises(KeyError, match="unknown scheme 'nonsense', expected one of ncdg_lv"):
        research.SCHEMES["nonsense"]


ALONE = OUTSIDE.split("class Half")[0]


@pytest.fixture
def alone(tmp_path):
    path = tmp_path / "my toy.py"
    path.write_text(ALONE)
    return path


def test_a_file_is_a_scheme_under_its_path(alone):
    assert str(alone) in research.SCHEMES
    assert research.SCHEMES[str(alone)].title == "Toy"
    assert str(alone) not in list(research.SCHEMES), "only what is installed is listed"


def test_a_file_that_was_changed_is_another_scheme(alone):
    before = research.SCHEMES.told(str(alone))
    assert research.SCHEMES.told(str(alone)) == before
    alone.write_text(ALONE.replace('"Toy"', '"Newer toy"'))
    assert research.SCHEMES[str(alone)].title == "Newer toy"
    alone.write_text(ALONE.replace("3, np.uint8", "3, dtype=np.uint8"))
    assert research.SCHEMES.told(str(alone)) != before
    assert research.SCHEMES.told(str(alone)).startswith("Toy (nowhere, file ")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\n", "has none, expected one class with the methods embed and extract"),
        (ALONE + ALONE.replace("Toy:", "Other:"), "has Toy, Other, expected one class"),
        (ALONE.replace("def extract", "def read"), "has none"),
        (
            ALONE.replace('"Toy", "nowhere", 3, True', '"Toy", 0, 0, 0').replace("blind =", "b ="),
            "lacks blind",
        ),
        ("import a_module_that_is_not_there\n", "cannot be loaded: ModuleNotFoundError"),
        ("def (\n", "cannot be loaded: SyntaxError"),
    ],
)
def test_a_file_without_one_scheme_is_refused(alone, text, message):
    alone.write_text(text)
    with pytest.raises(InputError, match=message):
        research.SCHEMES[str(alone)]


def test_a_file_that_is_not_there_is_said_to_be_missing(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the scheme .*nothing\.py: No such file"):
        research.SCHEMES[str(tmp_path / "nothing.py")]
