"""The folder for compiled kernels: numba's own where it works, a private one where not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from planner.shared import kernel_cache
from planner.shared.kernel_cache import choose_kernel_cache


@pytest.fixture
def bare_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    for name in ("NUMBA_CACHE_DIR", "CACHE_DIRECTORY", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, "")  # so that what a test chooses is undone after it
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path / "nobody"))
    monkeypatch.setattr(kernel_cache.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr(kernel_cache, "sys", type("NoModules", (), {"modules": {}}))
    return tmp_path


def test_a_writable_source_folder_is_left_to_numba(bare_environment: Path) -> None:
    assert choose_kernel_cache(bare_environment) is None
    assert "NUMBA_CACHE_DIR" not in os.environ


def test_a_variable_that_is_set_is_never_overruled(
    bare_environment: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/elsewhere")
    assert choose_kernel_cache(bare_environment / "not" / "there") is None
    assert os.environ["NUMBA_CACHE_DIR"] == "/elsewhere"


def test_a_service_gets_its_cache_directory(
    bare_environment: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CACHE_DIRECTORY", f"{bare_environment}/service:/other")
    folder = choose_kernel_cache(bare_environment / "not" / "there")
    assert folder == bare_environment / "service" / "kernels"
    assert os.environ["NUMBA_CACHE_DIR"] == str(folder)
    assert folder.stat().st_mode & 0o777 == 0o700


def test_a_folder_that_others_can_write_to_is_never_used(bare_environment: Path) -> None:
    planted = bare_environment / f"clearway-kernels-{os.getuid()}"
    planted.mkdir()
    planted.chmod(0o777)
    folder = choose_kernel_cache(bare_environment / "not" / "there")
    assert folder is not None
    assert folder != planted


def test_a_link_planted_by_others_is_never_followed(bare_environment: Path) -> None:
    target = bare_environment / "target"
    target.mkdir(mode=0o700)
    (bare_environment / f"clearway-kernels-{os.getuid()}").symlink_to(target)
    folder = choose_kernel_cache(bare_environment / "not" / "there")
    assert folder is not None
    assert folder.resolve() != target


def test_importing_the_scene_types_does_not_load_numba() -> None:
    code = (
        "import sys, planner.scene; sys.exit('numba' in sys.modules or 'networkx' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
