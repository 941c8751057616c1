"""All measurements, one after the other: `make bench`."""

from __future__ import annotations

import subprocess
import sys

MEASUREMENTS = (
    "roundtrip",
    "gltf_validity",
    "start_up",
    "saliency_speed",
    "embed_speed",
    "clean_channel",
    "false_positives",
    "code",
    "demodulator",
    "region_classifier",
    "metrics_validation",
    "marks",
    "recovery",
    "authentication",
)


def main() -> int:
    """Run every measurement in a process of its own; exit 1 where one missed its bar."""
    failed = []
    for name in MEASUREMENTS:
        print(f"\n== python -m claims.{name}", flush=True)
        if subprocess.run([sys.executable, "-m", f"claims.{name}"], check=False).returncode:
            failed.append(name)
    if failed:
        print("missed a bar:", ", ".join(failed))
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
