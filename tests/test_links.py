"""Links of the documents lead to files, and to headings that are there; every page is in the menu of the site."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from tests.counting import some
from tests.test_docs import tool_of

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("*-wheel/*.md"), *(ROOT / "docs").rglob("*.md")])
LINK = re.compile(r"\]\(([^)\s#:]*)(?:#([^)\s]*))?\)|<img src=\"([^\":]+)\"")


def prose(page: Path) -> str:
    """Return the text of a page without blocks and pieces of code."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return re.sub(r"`[^`\n]*\]\([^`\n]*`", "", text)


@cache
def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page, as GitHub and MyST make them."""
    found: dict[str, int] = {}
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for heading in re.findall(r"^#{1,6} +(.+?) *$", text, re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
        slug = re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")
        found[slug] = found.get(slug, -1) + 1
    return {slug + (f"-{k}" if k else "") for slug, count in found.items() for k in range(count + 1)}


def links(page: Path) -> list[tuple[str, str]]:
    """Return the file, "" for the page itself, and the anchor, "" for none, of each link within the repository."""
    return [(to or image, anchor) for to, anchor, image in LINK.findall(prose(page)) if to or anchor or image]


def test_links_lead_to_files():
    every = [(page, to) for page in PAGES for to, _ in links(page) if to]
    dead = [(page.name, to) for page, to in some(every, least=200) if not (page.parent / to).exists()]
    assert dead == []


def test_links_lead_to_headings():
    every = [
        (page, page if not to else (page.parent / to).resolve(), anchor)
        for page in PAGES
        for to, anchor in links(page)
        if anchor
    ]
    dead = [
        (page.name, to.name, anchor)
        for page, to, anchor in some(every, least=12)
        if anchor not in anchors(to)
    ]
    assert dead == []


@pytest.mark.parametrize(
    ("heading", "anchor"),
    [
        ("## 9. Our reading of the paper", "9-our-reading-of-the-paper"),
        ("## The page: `meshmark serve`", "the-page-meshmark-serve"),
        ("### A *second* one, of [two](other.txt)", "a-second-one-of-two"),
    ],
)
def test_anchors_are_those_of_github(heading, anchor, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"# One\n\n{heading}\n\n## One\n")
    assert anchors(page) == {"one", anchor, "one-1"}


def test_every_page_is_in_the_menu_of_the_site():
    site = tool_of("make_site")
    listed = {page for names in site.CHAPTERS.values() for page in names}
    placed = {place.removesuffix(".md") for place in site.pages().values()}
    assert {page for page in placed if not page.startswith("decisions/0")} == listed | {"index"}


def test_pages_of_the_site_link_to_pages_of_the_site():
    site = tool_of("make_site")
    placed = site.pages()
    decision = min(page for page in placed if page.startswith("docs/decisions/0"))
    text = "[a](docs/limits.md#x) ![p](docs/demo.jpg) [c](src/meshmark/late.py) [d](docs/decisions/) [no](gone.txt)"
    assert site.for_the_site(text, "README.md", placed) == (
        "[a](limits.md#x) ![p](demo.jpg) `c` [d](decisions/README.md) [no](gone.txt)"
    )
    back = site.for_the_site("[r](../../README.md) [a](../../ARCHITECTURE.md)", decision, placed)
    assert back == "[r](../index.md) [a](../ARCHITECTURE.md)"
