"""An environment with Clearway's wheel, made once."""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from planner.shared.kernel_locator import PACKAGES

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new virtual environment with the wheel of this checkout, and nothing of the checkout.

    The packages that it needs are those of the tests' environment, found by a path file: to
    install them again takes minutes of network and processor (``.ci/run`` does). Kernels that the
    checkout has compiled from the same sources are put where numba keeps them.
    """
    folder = tmp_path_factory.mktemp("installed")
    pip = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")
    build = ("--no-deps", "--no-index", "--no-build-isolation", "--wheel-dir", folder, ROOT)
    subprocess.run([*pip, "wheel", *build], check=True)
    (wheel,) = folder.glob("clearway-*.whl")
    environment = folder / "venv"
    venv.create(environment)
    python = environment / "bin" / "python"
    subprocess.run(
        [*pip, "--python", python, "install", "--no-deps", "--no-index", wheel], check=True
    )
    (site,) = environment.glob("lib/python3*/site-packages")
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    for package in PACKAGES:
        for kernel in (ROOT / package).rglob("__pycache__/*.nb[ci]"):
            place = site / kernel.relative_to(ROOT)
            if place.parents[1].is_dir():  # a folder that was renamed leaves its kernels behind
                place.parent.mkdir(exist_ok=True)
                shutil.copy2(kernel, place)
    return environment
