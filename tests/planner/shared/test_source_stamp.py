"""The stamp of a compiled kernel: all sources that it can depend on, and none that it cannot."""

from pathlib import Path

import pytest

from planner.shared import source_stamp
from planner.shared.source_stamp import stamp_of

FILES = {
    "house/__init__.py": "",
    "house/kernel.py": (
        "from house.floor import (  # a comment\n    tile,\n)\nimport house.wall\nimport numpy\n"
    ),
    "house/floor/__init__.py": "",
    "house/floor/tile.py": "    from house.wall import COLOUR\n",
    "house/wall.py": "from house.kernel import circle\nCOLOUR = 1\n",
    "house/garden.py": "TREES = 3\n",
    "numpy/__init__.py": "",  # beside it, where both are installed
}


@pytest.fixture
def house(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return tmp_path


def stamp(root: Path, versions: str = "numba 1") -> str:
    source_stamp._content.cache_clear()
    source_stamp._file_of.cache_clear()
    return stamp_of(root / "house" / "kernel.py", ("house",), versions)


@pytest.mark.parametrize("changed", ["house/kernel.py", "house/floor/tile.py", "house/wall.py"])
def test_a_change_in_anything_that_is_imported_changes_it(house: Path, changed: str) -> None:
    before = stamp(house)
    (house / changed).write_text(FILES[changed] + "# changed\n")
    assert stamp(house) != before


def test_strangers_beside_it_do_not_change_it(house: Path) -> None:
    before = stamp(house)
    (house / "numpy/__init__.py").write_text("pi = 3\n")
    assert stamp(house) == before
    (house / "numpy/__init__.py").unlink()
    assert stamp(house) == before


def test_what_is_not_imported_does_not_change_it(house: Path) -> None:
    before = stamp(house)
    (house / "house/garden.py").write_text("TREES = 4\n")
    assert stamp(house) == before


def test_a_folder_apart_does_not_change_it(house: Path) -> None:
    def without_the_floor() -> str:
        stamp(house)
        return stamp_of(house / "house/kernel.py", ("house",), "1", apart=house / "house" / "floor")

    before = without_the_floor()
    (house / "house/floor/tile.py").write_text("GREY = 1\nfrom house.wall import COLOUR\n")
    assert without_the_floor() == before
    (house / "house/wall.py").write_text("COLOUR = 2\n")
    assert without_the_floor() != before


def test_other_versions_of_the_compiler_change_it(house: Path) -> None:
    assert stamp(house, "numba 2") != stamp(house, "numba 1")


def test_the_same_sources_elsewhere_have_the_same_stamp(house: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    for name, text in FILES.items():
        (elsewhere / name).parent.mkdir(parents=True, exist_ok=True)
        (elsewhere / name).write_text(text)
    assert stamp(elsewhere) == stamp(house)
