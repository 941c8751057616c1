from __future__ import annotations

import subprocess
import sys
from importlib import resources

import pytest
from jinja2 import UndefinedError

from meshmark.report.html import _environment, html_page, trusted

HOSTILE = "<script>alert('x')</script>&\""


def rendered(template: str, **values: object) -> str:
    return _environment("report").from_string(template).render(**values)


def test_what_a_template_is_given_is_escaped_unless_it_is_ours():
    assert rendered("{{ text }}", text=HOSTILE) == "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&amp;&#34;"
    assert rendered("{{ text | prose }}", text=HOSTILE) == rendered("{{ text }}", text=HOSTILE)
    assert rendered("{{ text }}", text=trusted("<b>x</b>")) == "<b>x</b>"


def test_prose_keeps_units_beside_numbers_and_raises_powers():
    assert rendered("{{ text | prose }}", text="5 % below 10^−12 or n^g") == (
        "5&nbsp;% below 10<sup>−12</sup> or n^g"
    )


def test_a_value_that_is_missing_is_an_error():
    with pytest.raises(UndefinedError, match="'report' is undefined"):
        html_page("report.html", "report", title="t", policy="", style="", script="")


@pytest.mark.parametrize("folder", ["report", "research/benchmark/page"])
def test_every_template_is_in_the_package_and_compiles(folder):
    names = sorted(path.name for path in resources.files("meshmark").joinpath(folder, "templates").iterdir())
    assert any(name.endswith(".html") for name in names)
    for name in names:
        _environment(folder).get_template(name)


def test_the_library_is_imported_only_to_make_a_page():
    code = (
        "import sys, meshmark.cli.main, meshmark.report.authentication_page\n"
        "import meshmark.research.benchmark.page.page\n"
        "assert 'jinja2' not in sys.modules and 'markupsafe' not in sys.modules"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
