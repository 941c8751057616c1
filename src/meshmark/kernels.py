"""The linear algebra library takes the same path on every processor, so that the same input gives the same output.

OpenBLAS, which NumPy and SciPy come with, picks code for the processor it finds. Sums are then added up in another
order, and an optimisation that starts a last digit apart ends elsewhere (docs/decisions/0037-one-kernel.md). The
code that is asked for here runs on all processors of a family that are not very old; on others the library chooses.
"""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path

__all__ = ["same_on_every_processor"]

_VARIABLE = "OPENBLAS_CORETYPE"
_ARM = ("aarch64", "arm64")
_X86 = ("x86_64", "amd64")
# `IsProcessorFeaturePresent` of Windows, for AVX2.
_PF_AVX2 = 40
# Enough of Linux's list for the flags of its first core.
_FIRST_CORE = 8192


def same_on_every_processor() -> None:
    """Choose the code of OpenBLAS, for this process and those that it starts; it looks when NumPy is imported.

    What the environment says already stays, and nothing is done where NumPy has been imported.
    """
    if _VARIABLE in os.environ or "numpy" in sys.modules:
        return
    machine = platform.machine().lower()
    if machine in _ARM and sys.platform != "darwin":  # Apple's NumPy brings another library
        os.environ[_VARIABLE] = "ARMV8"
    elif machine in _X86 and _has_avx2():
        os.environ[_VARIABLE] = "Haswell"


def _has_avx2() -> bool:
    if sys.platform == "win32":
        import ctypes

        return bool(ctypes.windll.kernel32.IsProcessorFeaturePresent(_PF_AVX2))
    try:
        with Path("/proc/cpuinfo").open(encoding="ascii", errors="replace") as file:
            return "avx2" in file.read(_FIRST_CORE).split()
    except OSError:
        return False
