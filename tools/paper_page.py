"""The page docs/results/paper.md from a finished `meshmark bench paper`.

python tools/paper_page.py OUT [WORDS.md]

OUT: the folder of the run. WORDS.md: what is to be said first, by default nothing. The section of the
paper's tables and figures is taken over as it is, its plots copied to docs/images/.
"""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent / "docs"
FIRST, AFTER = "## The paper's tables and figures\n", "\n## What survives which attack"
MADE = re.compile(r"\nMade by `(.*)`\.\n")
PLOT = re.compile(r"\(plots/(paper-[\w-]+\.svg)\)")


def main(arguments: Sequence[str]) -> int:
    """Write the page; return 2 for wrong arguments or a folder without a report."""
    if not 1 <= len(arguments) <= 2 or not (Path(arguments[0]) / "report.md").is_file():
        print(__doc__, file=sys.stderr)
        return 2
    out = Path(arguments[0])
    words = Path(arguments[1]).read_text(encoding="utf-8") if len(arguments) == 2 else ""
    report = (out / "report.md").read_text(encoding="utf-8")
    section = report[report.index(FIRST) + len(FIRST) : report.index(AFTER)]
    made = MADE.search(section)
    for name in PLOT.findall(section):
        shutil.copyfile(out / "plots" / name, DOCS / "images" / name)
    section = PLOT.sub(r"(../images/\1)", MADE.sub("\n", section))
    command = f"\nMade by `{made[1]}` and `tools/paper_page.py`.\n" if made else ""
    page = f"# The paper's tables and figures, claimed and measured\n\n{words}{command}{section.rstrip()}\n"
    (DOCS / "results" / "paper.md").write_text(re.sub(r"\n{3,}", "\n\n", page), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
