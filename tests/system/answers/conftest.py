"""The pictures that the commands are asked about, once for a file of tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.pictures import box_and_disc, gate, save
from tests.system.answers.asked import zoo


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    save(folder, "two.png", box_and_disc())
    save(folder, "gate.png", gate())
    save(folder, "zoo.png", zoo())
    return folder
