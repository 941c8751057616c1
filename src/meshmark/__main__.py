"""`python -m meshmark` is the command `meshmark`."""

from __future__ import annotations

from meshmark.cli.main import run

if __name__ == "__main__":
    run()
