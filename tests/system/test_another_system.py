"""Library, commands on pictures and maps, and virtual runs need nothing that only Unix has."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from navigation.cli.main import COMMANDS

ROOT = Path(__file__).parents[2]
ANOTHER_SYSTEM = ROOT / "tests" / "support" / "another_system"
NAMES = ("clearway", "planner", "vision", "firmware_protocol", "navigation")
COLD_S = 800.0
ROBOTS = """name,start_x,start_y,goal_x,goal_y,radius
a,40,40,600,440,15
b,600,40,40,440,15
"""
NEARBY = "[{x_m: 0.3, y_m: 0.2}]"
"""A mission of three seconds in the configuration of `clearway init`."""

ANYWHERE = [
    "--help",
    "--version",
    "sample arena",
    "sample rooms",
    "extract arena.png -o scene.txt",
    "roadmap rooms.yaml --radius 0.2 -o roadmap.geojson",
    "audit roadmap.geojson --map rooms.yaml --radius 0.2",
    "plan arena.png --start 40,40 --goal 600,440 --radius 20 --render plan.svg",
    "fleet arena.png --robots robots.csv --render fleet.svg",
    "marker 7 -o marker.png",
    "markers marker.png",
    "init arena.yaml",
    "check arena.yaml",
    "schema",
    "completion bash",
    "sweep arena.yaml --runs 1 --workers 1 --spread 0 -o sweep.csv",
]
"""Commands that run on every system, in this order."""
LINUX = [
    "run arena.yaml --once",
    "demo --once",
    "robot",
    "dashboard recording",
    "go 1,1",
    "stop",
    "status",
    "doctor",
    "devices",
    "camera 0",
    "install-service arena.yaml",
]

PROGRAM = """
import contextlib, importlib, io, json, shlex, sys
import sitecustomize
assert sitecustomize.LACKS, "this is Linux: commands would drive"
from navigation.cli.main import run

def ran(line):
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as e:
        code = run(shlex.split(line))
    return code, e.getvalue()

def imported(package):
    module = importlib.import_module(package)
    missing = {}
    for name in module.__all__:
        try:
            getattr(module, name)
        except Exception as error:
            missing[name] = repr(error)
    return missing

if __name__ == "__main__":
    asked = json.loads(sys.argv[1])
    answers = {line: ran(f"--debug {line}") for line in asked["anywhere"]}
    answers |= {line: ran(line) for line in asked["linux"]}
    names = {package: imported(package) for package in asked["packages"]}
    print(json.dumps({"answers": answers, "names": names}))
"""


@pytest.fixture(scope="module")
def answered(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the commands and the imports say in one Python without Unix."""
    folder = tmp_path_factory.mktemp("another_system")
    (folder / "program.py").write_text(PROGRAM, encoding="utf-8")
    (folder / "robots.csv").write_text(ROBOTS, encoding="utf-8")
    helps = [f"{name} --help" for name in COMMANDS]
    asked = {"anywhere": [*ANYWHERE, *helps], "linux": LINUX, "packages": NAMES}
    done = subprocess.run(
        [sys.executable, "program.py", json.dumps(asked)],
        cwd=folder,
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join((str(ANOTHER_SYSTEM), str(ROOT))),
            "PYTHONWARNDEFAULTENCODING": "1",
            "OPENCV_LOG_LEVEL": "SILENT",
            "CLEARWAY_MISSION__STATIONS": NEARBY,
        },
        capture_output=True,
        text=True,
        timeout=COLD_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_the_stub_hides_what_windows_lacks() -> None:
    program = (
        "__name__ = 'planner.example'\n"
        "import os, sys, socket, select, signal\n"
        "from os import path\n"
        "try:\n    import fcntl\n    print('fcntl')\nexcept ImportError:\n    pass\n"
        "print(sys.platform, hasattr(os, 'getuid'), hasattr(socket, 'AF_UNIX'),"
        " hasattr(select, 'poll'), hasattr(signal, 'SIGHUP'), hasattr(os, 'O_CLOEXEC'),"
        " hasattr(os, 'getpid'), hasattr(signal, 'SIGTERM'), path.join('a', 'b'))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONPATH": str(ANOTHER_SYSTEM)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["win32", *["False"] * 5, "True", "True", "a/b"]


@pytest.mark.parametrize("package", NAMES)
def test_every_public_name_is_imported(package: str, answered: dict[str, Any]) -> None:
    assert answered["names"][package] == {}


@pytest.mark.timeout(COLD_S + 100)
@pytest.mark.parametrize("line", ANYWHERE)
def test_a_command_runs(line: str, answered: dict[str, Any]) -> None:
    code, error = answered["answers"][line]
    assert code == 0, error


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_its_help(name: str, answered: dict[str, Any]) -> None:
    code, error = answered["answers"][f"{name} --help"]
    assert code == 0, error


@pytest.mark.parametrize("line", LINUX)
def test_a_command_of_the_daemon_says_that_it_needs_linux(
    line: str, answered: dict[str, Any]
) -> None:
    code, error = answered["answers"][line]
    assert code == 2, error
    assert f"{line.split()[0]}" in error
    assert ": needs Linux" in error
    assert "Traceback" not in error
