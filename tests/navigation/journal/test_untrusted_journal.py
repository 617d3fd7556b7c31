"""What cannot be trusted is never driven: foreign, later and damaged journals."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from navigation.journal.journal import Journal, JournalError
from navigation.journal.journal_file import KIND, VERSION
from navigation.journal.journal_records import Contents, RecordError, from_text, to_text
from navigation.shared.sealed import seal
from tests.navigation.journal.kept import DRIVING, OWNER, PLAN, aside, keep

# What cannot be trusted.


def test_a_file_that_is_no_journal_is_refused_and_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("these are my notes, and quite long ones at that " * 50)
    before = path.read_bytes()
    with pytest.raises(JournalError, match=r"notes\.txt"):
        Journal(path, OWNER)
    assert path.read_bytes() == before


SEALED = seal(KIND, VERSION, "{}")


def test_another_program_s_database_is_refused_and_left_alone(path: Path) -> None:
    path.write_bytes(b"SQLite format 3\x00".ljust(4096, b"\x01"))
    before = path.read_bytes()
    with pytest.raises(JournalError, match="is no journal"):
        Journal(path, OWNER)
    assert path.read_bytes() == before
    assert aside(path) == ["journal"]


def test_a_journal_of_a_later_version_is_refused(path: Path) -> None:
    path.write_bytes(seal(KIND, 99, "what a later program writes"))
    with pytest.raises(JournalError, match="version 99"):
        Journal(path, OWNER)
    assert aside(path) == ["journal"]


def test_an_empty_file_is_damage_and_no_file_is_not(path: Path) -> None:
    with Journal(path, OWNER) as journal:
        assert (journal.mission(), journal.remark) == (None, "")
    path.touch()
    with Journal(path, OWNER) as journal:
        assert journal.mission() is None
        assert "is empty: kept as journal.damaged-1" in journal.remark


def harmed(change: Callable[[dict[str, Any]], object]) -> str:
    body = json.loads(to_text(Contents(OWNER, DRIVING, PLAN)))
    change(body)
    return json.dumps(body)


def at(*where: str | int, value: object) -> Callable[[dict[str, Any]], object]:
    def change(body: dict[str, Any]) -> None:
        here: Any = body
        for part in where[:-1]:
            here = here[part]
        here[where[-1]] = value

    return change


HERE = {"x": 0, "y": 0, "heading_rad": None, "dwell_s": 0}
TEXTS = {
    "not a number": harmed(at("mission", "stations", 0, "x", value=float("nan"))),
    "infinite": harmed(at("mission", "stations", 0, "x", value="X")).replace('"X"', "1e400"),
    "a word for a number": harmed(at("mission", "stations", 0, "y", value="1.0")),
    "true for a number": harmed(at("mission", "stations", 0, "y", value=True)),
    "outside": harmed(at("mission", "stations", 0, "y", value=1e4)),
    "too long a stay": harmed(at("mission", "stations", 0, "dwell_s", value=1e9)),
    "more visited than there are": harmed(at("mission", "visited", value=3)),
    "fewer than none": harmed(at("mission", "visited", value=-1)),
    "half a visit": harmed(at("mission", "visited", value=0.5)),
    "no state": harmed(at("mission", "state", value="FLYING")),
    "no stations": harmed(at("mission", "stations", value=[])),
    "too many stations": harmed(
        at("mission", "stations", value=1001 * [HERE])
    ),
    "a key too many": harmed(at("mission", "color", value="red")),
    "a key too few": harmed(lambda body: body["mission"].pop("paused")),
    "an id that is none": harmed(at("plan", "mission_id", value=1 << 32)),
    "an endless target": harmed(at("plan", "targets", 0, "x_m", value="X")).replace(
        '"X"', "-1e999"
    ),
    "a station too many": harmed(at("plan", "targets", 0, "station", value=3)),
    "a list": "[]",
    "nothing": "",
    "half a text": to_text(Contents(OWNER, DRIVING, PLAN))[:-40],
    "nested": "[" * 100_000,
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTS)
def test_a_record_that_cannot_be_is_refused_in_a_sentence(path: Path, name: str) -> None:
    with pytest.raises(RecordError) as caught:
        from_text(TEXTS[name])
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400
    keep(path)
    path.write_bytes(seal(KIND, VERSION, TEXTS[name]))
    with Journal(path, OWNER) as journal:
        assert journal.mission() is None
        assert journal.plan() is None
        assert "cannot be used" in journal.remark


def test_a_record_whose_checksum_is_wrong_is_never_driven(path: Path) -> None:
    keep(path)
    whole = path.read_bytes()
    assert b"2.0" in whole
    path.write_bytes(whole.replace(b"2.0", b"2.1"))
    with Journal(path, OWNER) as journal:
        assert journal.unfinished() is None
        assert journal.remark == (
            f"journal {path}: is damaged (its checksum): kept as journal.damaged-1; "
            "the run begins without it"
        )


@pytest.mark.parametrize("harm", [bytes(4096), b"\xff" + SEALED[1:], SEALED[:15]])
def test_what_is_left_of_a_journal_is_told_from_somebody_s_notes(path: Path, harm: bytes) -> None:
    path.write_bytes(harm)
    with Journal(path, OWNER) as journal:
        assert journal.mission() is None
        assert "is damaged (its first bytes): kept as journal.damaged-1" in journal.remark


def test_the_format_s_number_is_the_latest() -> None:
    assert VERSION == 3
