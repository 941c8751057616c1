"""The measurements behind the published figures: `python -m claims` runs them (`make bench`), `--list` names them.

Each is a command of its own, `python -m claims.NAME`; docs/claims.md says what each prints and how long it takes.
"""

from __future__ import annotations

import argparse
import subprocess
import sys

__all__ = ["ALONE", "COMMANDS", "main"]

# Name -> the page that quotes its figures. Those in ALONE need arguments, days, or a commit to compare with, so
# `make bench` leaves them out.
COMMANDS = {
    "authenticate_speed": "docs/results/authentication.md",
    "authentication": "docs/results/authentication.md",
    "batch_runs": "docs/decisions/0029-batch.md",
    "by_hand": "docs/decisions/0015-by-hand-or-library.md",
    "cell_locks": "docs/results/false-positives.md",
    "clean_channel": "docs/results/clean-channel.md",
    "coarse": "docs/results/coarse.md",
    "code": "docs/decisions/0004-code.md",
    "compressed_gltf": "docs/decisions/0002-compressed-gltf.md",
    "costa": "docs/results/ownership.md",
    "crops_and_mosaics": "docs/results/crops.md",
    "demodulator": "docs/claims.md",
    "embed_speed": "docs/claims.md",
    "false_alarms": "docs/decisions/0008-authentication-marks.md",
    "false_positives": "docs/results/false-positives.md",
    "gltf_validity": "docs/claims.md",
    "hostile": "docs/decisions/0016-odd-files.md",
    "large_models": "docs/performance.md",
    "lattice_labels": "docs/decisions/0020-one-lattice-per-model.md",
    "marks": "docs/decisions/0008-authentication-marks.md",
    "metrics_validation": "docs/decisions/0005-metrics.md",
    "original_recovery": "docs/decisions/0028-recovery-with-the-original.md",
    "parts_of_assemblies": "docs/decisions/0035-parts-of-assemblies.md",
    "performance": "docs/performance.md",
    "point_locks": "docs/results/coarse.md",
    "princeton": "docs/results/field-files.md",
    "published": "docs/results/published.md",
    "recovery": "docs/decisions/0007-payload-recovery.md",
    "region_classifier": "docs/decisions/0010-layers-and-regions.md",
    "registration": "docs/claims.md",
    "registry_innocent": "docs/decisions/0025-registry.md",
    "registry_issue": "docs/decisions/0025-registry.md",
    "registry_scale": "docs/decisions/0025-registry.md",
    "registry_traces": "docs/decisions/0025-registry.md",
    "report_pages": "docs/report.md",
    "rivals_sanity": "docs/results/rivals-sanity.txt",
    "roundtrip": "docs/decisions/0016-odd-files.md",
    "saliency_speed": "docs/claims.md",
    "same_behaviour": "docs/decisions/0018-layout.md",
    "search_use": "docs/decisions/0044-absent-of-small-models.md",
    "security": "docs/results/security.md",
    "serve_fuzz": "docs/serve.md",
    "serve_load": "docs/serve.md",
    "sizing": "docs/sizing.md",
    "start_up": "docs/decisions/0015-by-hand-or-library.md",
    "visible_share": "docs/results/ownership.md",
    "web_exports": "docs/decisions/0023-tolerance-web.md",
}
ALONE = {
    "authenticate_speed", "batch_runs", "by_hand", "coarse", "compressed_gltf", "costa", "crops_and_mosaics",
    "false_alarms", "false_positives", "hostile", "large_models", "lattice_labels", "original_recovery",
    "parts_of_assemblies", "performance", "princeton", "published", "registration", "rivals_sanity",
    "same_behaviour", "search_use", "security", "sizing", "web_exports",
}  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """Run each measurement in a process of its own; exit 1 where one missed its bar."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--list", action="store_true", help="name all measurements and the pages they are for"
    )
    if parser.parse_args(arguments).list:
        for name, page in COMMANDS.items():
            print(f"python -m claims.{name:20} {page}{' (by itself only)' if name in ALONE else ''}")
        return 0
    failed = []
    for name in COMMANDS:
        if name in ALONE:
            continue
        print(f"\n== python -m claims.{name}", flush=True)
        if subprocess.run([sys.executable, "-m", f"claims.{name}"], check=False).returncode:
            failed.append(name)
    if failed:
        print("missed a bar:", ", ".join(failed))
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
