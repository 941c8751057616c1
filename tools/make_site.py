"""Make a web site of the documents: python tools/make_site.py, or `make site`. Nothing is loaded from a network.

README.md is its first page. Sphinx with MyST reads the Markdown, Furo draws it; a link that leads nowhere fails the
build. Links to files that are no pages (sources) become their names.
"""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from os.path import normpath, relpath
from pathlib import Path

from meshmark import __version__

ROOT = Path(__file__).resolve().parents[1]
SITE = ROOT / "tools" / "site"
OUT = ROOT / "site-out"
CHAPTERS = {
    "Start": ("quickstart", "tour", "gallery"),
    "By task": ("ownership", "changes", "tracing", "keys", "blender", "batch", "serve", "report"),
    "Look up": ("reference", "cli", "answers", "python", "sizing", "performance"),
    "Understand": (
        "limits",
        "design",
        "claims",
        "decisions/README",
        "ARCHITECTURE",
        "CONTRIBUTING",
        "CHANGELOG",
    ),
    "Compare schemes": ("compare", "benchmark", "leaderboard", "rivals", "your-scheme"),
    "Results": tuple(f"results/{path.stem}" for path in sorted((ROOT / "docs" / "results").glob("*.md"))),
}
"""Captions of the menu, and their pages in order; decisions are listed below their index."""
LINK = re.compile(r"(!?)\[([^\[\]]*)\]\(([^)\s:#]+)(#[^)\s]*)?\)")
FENCED = re.compile(r"(```.*?```)", re.DOTALL)
IMAGE_TAG = re.compile(r'(<img src=")([^":]+)(")')


def pages() -> dict[str, str]:
    """Return where each Markdown file of the repository lies in the site, by its path in the repository."""
    found = {"README.md": "index.md"}
    found |= {f"{name}.md": f"{name}.md" for name in ("ARCHITECTURE", "CONTRIBUTING", "CHANGELOG")}
    docs = ROOT / "docs"
    return found | {f"docs/{p}": p for p in sorted(str(p.relative_to(docs)) for p in docs.rglob("*.md"))}


def for_the_site(text: str, page: str, placed: dict[str, str]) -> str:
    """Return a page with the links that it has in the site.

    page: its path in the repository; placed: of `pages`.
    """
    home = str(Path(page).parent)
    here = str(Path(placed[page]).parent)

    def target(to: str) -> str | None:
        whole = normpath(f"{home}/{to}")
        inside = placed.get(whole) or placed.get(f"{whole}/README.md")
        if inside is None and whole.startswith("docs/") and Path(ROOT / whole).is_file():
            inside = whole.removeprefix("docs/")
        if not (ROOT / whole).exists():
            return to  # which Sphinx reports
        return None if inside is None else relpath(inside, here)

    def link(found: re.Match[str]) -> str:
        new = target(found[3])
        if new is None:
            return found[2] if "`" in found[2] else f"`{found[2]}`"
        return f"{found[1]}[{found[2]}]({new}{found[4] or ''})"

    parts = FENCED.split(text)
    parts[::2] = [LINK.sub(link, part) for part in parts[::2]]
    return IMAGE_TAG.sub(lambda found: f"{found[1]}{target(found[2])}{found[3]}", "".join(parts))


def menu() -> str:
    """Return the tables of contents, which the first page holds hidden."""
    return "".join(
        f"\n```{{toctree}}\n:caption: {caption}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"
        for caption, names in CHAPTERS.items()
    )


def gather(folder: Path) -> None:
    """Put the pages and pictures of the site, with its settings, into a folder."""
    shutil.copytree(ROOT / "docs", folder, dirs_exist_ok=True)
    placed = pages()
    for page, place in placed.items():
        text = for_the_site((ROOT / page).read_text(encoding="utf-8"), page, placed)
        if place == "index.md":
            text += menu()
        if place == "decisions/README.md":
            text += "\n```{toctree}\n:hidden:\n:glob:\n\n0*\n```\n"
        (folder / place).write_text(text, encoding="utf-8")
    shutil.copytree(SITE, folder, dirs_exist_ok=True)


def main() -> int:
    """Build the site; the exit code is that of Sphinx, which takes warnings as errors."""
    from sphinx.cmd.build import main as sphinx

    with tempfile.TemporaryDirectory() as name:
        gather(Path(name))
        shutil.rmtree(OUT, ignore_errors=True)
        settings = ["-D", f"release={__version__}", "-d", f"{name}/.doctrees"]
        code = sphinx(["-q", "-W", "--keep-going", *settings, name, str(OUT)])
    if not code:
        print(f"the site is in {OUT}; its first page is {OUT / 'index.html'}")
    return code


if __name__ == "__main__":
    sys.exit(main())
