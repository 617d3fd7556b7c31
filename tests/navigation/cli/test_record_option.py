"""`clearway run --record`: what is no place for a recording is refused where it is typed."""

from __future__ import annotations

from pathlib import Path

import pytest

from navigation.cli.main import run
from navigation.recording.names import place_of

USUAL = Path("recordings")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a recording, another file and a folder with a dot in its name."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.mcap").write_text("a recording")
    (tmp_path / "notes").write_text("a text")
    (tmp_path / "of.may").mkdir()
    (tmp_path / "folder.mcap").mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ("place", "what"),
    [
        ("old.mcap", "old.mcap: exists already, and a recording overwrites nothing"),
        ("folder.mcap", "folder.mcap: is a directory, must be a file"),
        ("gone/new.mcap", "gone/new.mcap: there is no directory gone"),
        ("new.bag", "new.bag: must end in .mcap, or be a directory"),
        ("new.mcap.gz", "new.mcap.gz: must end in .mcap, or be a directory"),
        ("notes", "notes: is a file, must be a new FILE.mcap or a directory"),
    ],
)
def test_what_is_no_place_for_a_recording_is_refused(folder, capsys, place, what):
    assert run(["run", "gone.yaml", "--record", place]) == 2
    assert f"Invalid value for '--record': {what}" in capsys.readouterr().err
    assert (folder / "old.mcap").read_text() == "a recording"


@pytest.mark.parametrize("place", ["new.mcap", "NEW.MCAP", "of.may", "recorded", "deep/er", "."])
def test_a_new_file_or_a_folder_is_taken(folder, capsys, place):
    assert run(["run", "gone.yaml", "--record", place]) == 78, (
        "the configuration is what is missing"
    )
    assert "--record" not in capsys.readouterr().err


def test_only_the_suffix_makes_it_a_file():
    assert place_of(None, USUAL) == (USUAL, None)
    assert place_of(Path("kept"), USUAL) == (Path("kept"), None)
    assert place_of(Path("a/b.mcap"), USUAL) == (Path("a"), "b.mcap")
    assert place_of(Path("b.MCAP"), USUAL) == (Path(), "b.MCAP")
