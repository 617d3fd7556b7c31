"""The Containerfile, read as text: what it copies and calls exists, and its page says the same.

No test builds it: that needs a registry's base image, and minutes of compiling.
"""

from __future__ import annotations

import fnmatch
import importlib.util
import json
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from navigation.cli.main import COMMANDS

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PAGE = (ROOT / "docs/how_to/container.md").read_text(encoding="utf-8")
KNOWN = {"ARG", "FROM", "RUN", "USER", "WORKDIR", "COPY", "ENV", "ENTRYPOINT", "CMD"}


def instructions() -> list[tuple[str, str]]:
    """Each instruction and its text, with continued lines joined and comments left out."""
    lines = (ROOT / "Containerfile").read_text(encoding="utf-8").splitlines()
    text = "\n".join(line for line in lines if not line.startswith("#"))
    joined = re.sub(r"\\\n\s*", "", text)
    return [
        (name, rest.strip())
        for name, _, rest in (line.partition(" ") for line in joined.splitlines() if line)
    ]


def texts(name: str) -> list[str]:
    return [text for found, text in instructions() if found == name]


def copied() -> list[str]:
    """The sources of every COPY."""
    words = [shlex.split(text) for text in texts("COPY")]
    return [word for each in words for word in each[:-1] if not word.startswith("--")]


def test_every_instruction_is_one_that_this_test_reads() -> None:
    assert {name for name, _ in instructions()} == KNOWN
    assert instructions()[0][0] == "ARG"  # the base, for a registry of one's own


def test_what_the_wheel_is_made_of_is_copied_and_nothing_else() -> None:
    wheel = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    made_of = {*wheel, PROJECT["project"]["readme"], *PROJECT["project"]["license-files"]}
    assert set(copied()) == {"pyproject.toml", *made_of}
    for name in copied():
        assert (ROOT / name).exists(), name
        assert f"sources/{name}" in " ".join(texts("COPY")) or (ROOT / name).is_file()


def test_what_is_copied_makes_the_whole_wheel(tmp_path: Path) -> None:
    sources = tmp_path / "sources"
    sources.mkdir()
    for name in copied():
        if (ROOT / name).is_dir():
            left_out = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, sources / name, ignore=left_out)
        else:
            shutil.copy(ROOT / name, sources)
    pip = (sys.executable, "-m", "pip", "--quiet", "wheel", "--no-deps", "--no-index")
    build = ("--no-build-isolation", "--wheel-dir", tmp_path, sources)
    subprocess.run([*pip, *build], check=True)
    (wheel,) = tmp_path.glob("clearway-*.whl")
    with zipfile.ZipFile(wheel) as packing:
        packed = set(packing.namelist())
    files = [file for file in sources.glob("*/**/*") if file.is_file()]
    assert {str(file.relative_to(sources)) for file in files} <= packed


def test_what_is_copied_is_not_ignored() -> None:
    lines = (ROOT / ".containerignore").read_text(encoding="utf-8").splitlines()
    patterns = [line for line in lines if line and not line.startswith("#")]
    for name in copied():
        assert not [pattern for pattern in patterns if fnmatch.fnmatch(name, pattern)], name
    assert "**/__pycache__" in patterns  # kernels of another Python, and of another processor


def test_what_is_called_exists() -> None:
    run = " ".join(texts("RUN"))
    (module,) = re.findall(r"-m (navigation[\w.]+)", run)
    assert importlib.util.find_spec(module) is not None
    (program,) = json.loads(texts("ENTRYPOINT")[0])
    assert program in PROJECT["project"]["scripts"]
    command = json.loads(texts("CMD")[0])
    assert command[0] in COMMANDS


def test_the_program_does_not_run_as_root() -> None:
    names = [name for name, _ in instructions()]
    assert texts("USER") == ["clearway"]
    assert names.index("USER") < names.index("COPY") < names.index("ENTRYPOINT")


@pytest.mark.parametrize("line", re.findall(r"clearway (?:\w+)(?: .*)?$", PAGE, re.M))
def test_a_command_on_the_page_is_one_of_clearway_s(line: str) -> None:
    assert line.split()[1] in COMMANDS, line


def test_page_and_file_name_the_same_folder_and_configuration() -> None:
    assert f"./arena:{texts('WORKDIR')[-1]} " in PAGE
    assert json.loads(texts("CMD")[0])[1] in PAGE
    assert "XDG_STATE_HOME=/arena/state" in texts("ENV")[0]
    assert "`state/`" in PAGE
