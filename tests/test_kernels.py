"""The linear algebra library takes the same path on every processor."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from threadpoolctl import threadpool_info

from meshmark import kernels

PRINT = "import os; print(os.environ.get('OPENBLAS_CORETYPE'))"


def said(code: str, **environment: str) -> str:
    kept = {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=kept | environment, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


@pytest.fixture
def chosen(monkeypatch):
    """What is chosen on a processor, which may have AVX2; None for nothing."""

    def choose(machine, avx2=False, platform="linux", **environment):
        monkeypatch.setattr(kernels.platform, "machine", lambda: machine)
        monkeypatch.setattr(kernels.sys, "platform", platform)
        monkeypatch.setattr(kernels.sys, "modules", {})
        monkeypatch.setattr(kernels, "_has_avx2", lambda: avx2)
        monkeypatch.setattr(kernels.os, "environ", environment)
        kernels.same_on_every_processor()
        return environment.get("OPENBLAS_CORETYPE")

    return choose


def test_one_choice_for_each_family_of_processors(chosen):
    assert chosen("x86_64", avx2=True) == "Haswell"
    assert chosen("AMD64", avx2=True, platform="win32") == "Haswell"
    assert chosen("x86_64") is None
    assert chosen("aarch64") == "ARMV8"
    assert chosen("arm64", platform="darwin") is None
    assert chosen("riscv64", avx2=True) is None


def test_what_the_environment_says_stays(chosen):
    assert chosen("x86_64", avx2=True, OPENBLAS_CORETYPE="Zen") == "Zen"


def test_a_process_that_has_numpy_already_is_left_alone():
    assert said("import numpy, meshmark; " + PRINT) == "None"
    assert said("import meshmark; " + PRINT) == said("import meshmark.coding.keys; " + PRINT)


def test_these_tests_run_as_the_program_does():
    import numpy  # noqa: F401  so that its library is there

    wanted = said("import meshmark; " + PRINT)
    found = {each["architecture"] for each in threadpool_info() if each["internal_api"] == "openblas"}
    assert wanted == "None" or {each.lower() for each in found} <= {wanted.lower()}
