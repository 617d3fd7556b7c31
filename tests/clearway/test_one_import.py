"""`import clearway`: the other packages' own names, and the version that everything has."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import clearway
import navigation
import planner
import vision
from navigation.cli.man_page import man_page

TOP = Path(__file__).resolve().parents[2]
VERSION = tomllib.loads((TOP / "pyproject.toml").read_text())["project"]["version"]


def test_every_name_is_the_packages_own() -> None:
    for name in clearway.__all__:
        owner = next(part for part in (vision, planner, navigation) if name in part.__all__)
        assert getattr(clearway, name) is getattr(owner, name), name


def test_importing_it_imports_neither_picture_nor_kernel() -> None:
    code = "import clearway, sys; print({'cv2', 'numba', 'planner'} & set(sys.modules))"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "set()\n"


def test_the_project_file_has_the_version_of_all() -> None:
    assert clearway.__version__ == version("clearway") == VERSION
    command = [sys.executable, "-m", "navigation.cli.main", "--version"]
    code = "from navigation.cli.main import main; main(['--version'])"
    command = [sys.executable, "-c", code]
    said = subprocess.run(command, capture_output=True, text=True, check=True)
    assert said.stdout == f"clearway {VERSION}\n"
    assert f"Clearway {VERSION}" in man_page().splitlines()[0]


def test_the_changelog_begins_with_what_is_unreleased_and_with_this_version() -> None:
    lines = (TOP / "CHANGELOG.md").read_text().splitlines()
    headings = [line.split()[1] for line in lines if line.startswith("## ")]
    assert headings[:2] == ["Unreleased", VERSION]


def test_the_robots_packages_have_the_same_version() -> None:
    robot = TOP / "firmware_protocol/robot/package.json"
    arduino = TOP / "firmware_protocol/firmware/arduino"
    properties = (arduino / "library.properties").read_text().splitlines()
    assert json.loads(robot.read_text())["version"] == VERSION
    assert json.loads((arduino / "library.json").read_text())["version"] == VERSION
    assert f"version={VERSION}" in properties
