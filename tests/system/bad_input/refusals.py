"""What every refusal has in common: its code, one sentence, the words that it must hold."""

from __future__ import annotations

from pathlib import Path

from tests.support.pictures import Told

JOURNEY = ("--start", "40,40", "--goal", "600,440", "--radius", "9")
CONFIGS = Path(__file__).parents[3] / "configs"


def assert_refused(told: Told, code: int, *words: str) -> None:
    """One sentence on stderr that says each of ``words``, and nothing on stdout."""
    assert told.code == code, told
    lines = told.err.splitlines()
    assert len(lines) == 1, told.err
    assert lines[0].startswith("clearway: error: ")
    assert "Traceback" not in told.err
    assert "unexpected" not in told.err, "an error that nobody foresaw"
    for word in words:
        assert word in lines[0]
    assert told.out == ""


def assert_no_path(told: Told, *words: str) -> None:
    """Exit code 3, and the reason once, as one sentence on stderr."""
    assert told.code == 3, told
    lines = told.err.splitlines()
    assert len(lines) == 1, told.err
    assert lines[0].startswith("clearway: no path for a robot of radius ")
    for word in words:
        assert word in lines[0]
    assert "no path" not in told.out
    assert "path of length" not in told.out
