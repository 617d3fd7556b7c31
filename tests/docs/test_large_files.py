"""The repository holds no large file, so that a clone stays quick."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LARGEST_BYTES = 500 * 1024


def test_no_file_of_the_repository_is_large() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("not a clone: the files of the repository are not known")
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    files = [ROOT / name for name in listed.stdout.split("\0") if name]
    assert len(files) > 1000
    large = [one.name for one in files if one.is_file() and one.stat().st_size > LARGEST_BYTES]
    assert large == []
