"""`clearway sample` writes what its next command then reads, over nobody's file."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

import planner
from navigation.cli.main import run
from navigation.cli.setup.sample import NEXT
from planner.samples.sample import SAMPLES


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_the_command_that_it_names_finds_a_path(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["sample", name]) == 0
    file = SAMPLES[name][0]
    said = capsys.readouterr().out.strip()
    assert said.startswith(f"wrote {file}; next: clearway plan {file} ")
    assert Path(file).read_bytes() == planner.sample(name).read_bytes()
    assert run(shlex.split(said.partition("next: clearway ")[2])) == 0
    assert Path("plan.svg").exists()


def test_every_sample_has_a_next_command() -> None:
    assert set(NEXT) == set(SAMPLES)


def test_a_file_that_is_there_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "rooms.pgm"
    mine.write_text("mine")
    assert run(["sample", "rooms", "--into", str(tmp_path)]) == 2
    assert f"{mine} exists; --force overwrites it" in capsys.readouterr().err
    assert mine.read_text() == "mine"
    assert not (tmp_path / "rooms.yaml").exists()
    assert run(["sample", "rooms", "--into", str(tmp_path), "--force"]) == 0
    assert planner.load_scene(tmp_path / "rooms.yaml").units == "m"


def test_another_name_is_refused_with_those_that_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["sample", "hall"]) == 2
    assert "'arena', 'photograph', 'maze', 'rooms'" in capsys.readouterr().err
