"""Pictures and scenes, a configuration's text, and a folder with what configurations name."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.pictures import blank, box_and_disc, save
from tests.system.bad_input.refusals import CONFIGS


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A picture that is well, and files that are not."""
    folder = tmp_path_factory.mktemp("bad")
    well = save(folder, "well.png", box_and_disc()).read_bytes()
    save(folder, "black.png", blank(200, 200, 0))
    save(folder, "one_black.png", blank(1, 1, 0))
    (folder / "empty.png").write_bytes(b"")
    (folder / "head_only.png").write_bytes(well[:60])
    (folder / "half.png").write_bytes(well[: len(well) // 2])
    (folder / "words.png").write_text("this is no picture\n")
    (folder / "noise.png").write_bytes(np.random.default_rng(1).bytes(2000))
    (folder / "folder.png").mkdir()
    (folder / "words.txt").write_text("this is no scene\n")
    (folder / "short.map").write_text("type octile\nheight 4\nwidth 4\nmap\n....\n")
    (folder / "no_image.yaml").write_text(
        "image: gone.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n"
    )
    return folder


# Configurations.


@pytest.fixture
def text() -> str:
    """The simulated run's configuration; its neighbours are copied beside each test's file."""
    return (CONFIGS / "simulation.yaml").read_text()


@pytest.fixture
def tmp_path(tmp_path: Path) -> Path:
    """A folder with everything that the shipped configurations name."""
    shutil.copytree(CONFIGS, tmp_path, dirs_exist_ok=True)
    return tmp_path
