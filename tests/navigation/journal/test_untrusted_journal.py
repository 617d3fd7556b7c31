"""What cannot be trusted is never driven: foreign, older, later and damaged journals."""

import json
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from navigation.journal import journal_file
from navigation.journal.journal import Journal, JournalError
from navigation.journal.journal_file import VERSION
from navigation.journal.journal_records import Contents, RecordError, from_text, to_text
from tests.navigation.journal.kept import DRIVING, OWNER, PLAN, aside, keep

# What cannot be trusted.


def test_a_file_that_is_no_journal_is_refused_and_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("these are my notes, and quite long ones at that " * 50)
    before = path.read_bytes()
    with pytest.raises(JournalError, match=r"notes\.txt"):
        Journal(path, OWNER)
    assert path.read_bytes() == before


def test_another_program_s_database_is_refused_and_left_alone(path: Path) -> None:
    with closing(sqlite3.connect(path)) as db:
        db.execute("CREATE TABLE addresses (name TEXT)")
    with pytest.raises(JournalError, match="another program's database"):
        Journal(path, OWNER)
    with closing(sqlite3.connect(path)) as db:
        assert db.execute("SELECT count(*) FROM addresses").fetchone() == (0,)


def test_a_journal_of_a_later_version_is_refused(path: Path) -> None:
    with closing(sqlite3.connect(path)) as db:
        db.execute("PRAGMA user_version=99")
    with pytest.raises(JournalError, match="version 99"):
        Journal(path, OWNER)


def test_a_journal_of_an_earlier_version_is_kept_aside(path: Path) -> None:
    with closing(sqlite3.connect(path)) as db:
        db.execute("CREATE TABLE mission (one INTEGER PRIMARY KEY, body TEXT NOT NULL)")
        db.execute("CREATE TABLE plan (one INTEGER PRIMARY KEY, body TEXT NOT NULL)")
        db.execute("PRAGMA user_version=1")
    with Journal(path, OWNER) as journal:
        assert "is of version 1" in journal.remark
        assert "begins without it" in journal.remark
        assert journal.unfinished() is None
        journal.keep(DRIVING, None, 0.0)
    assert aside(path) == ["journal", "journal.version1-1"]


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
    with closing(sqlite3.connect(path)) as db, db:
        row = (TEXTS[name], journal_file._sum(TEXTS[name]))
        db.execute("UPDATE contents SET body = ?, sum = ?", row)
    with Journal(path, OWNER) as journal:
        assert journal.mission() is None
        assert journal.plan() is None
        assert "cannot be used" in journal.remark


def test_a_record_whose_checksum_is_wrong_is_never_driven(path: Path) -> None:
    keep(path)
    with closing(sqlite3.connect(path)) as db, db:
        db.execute("UPDATE contents SET body = replace(body, '2.0', '2.1')")
    with Journal(path, OWNER) as journal:
        assert journal.unfinished() is None
        assert journal.remark == (
            f"journal {path}: is damaged (its checksum): kept as journal.damaged-1; "
            "the run begins without it"
        )


def test_damaged_bytes_never_drive_and_never_end_the_run(path: Path) -> None:
    """Whatever byte is another, or is missing: the very mission or none."""
    keep(path)
    whole = path.read_bytes()
    refused = 0
    for harm in harms(whole):
        for file in path.parent.iterdir():
            file.unlink()
        path.write_bytes(harm)
        try:
            with Journal(path, OWNER) as journal:
                assert journal.mission() in (None, DRIVING)
                assert journal.plan() in (None, PLAN)
                journal.keep(DRIVING, PLAN, 0.0)
        except JournalError:
            refused += 1
    assert refused <= 12, "a damaged journal is told from somebody's notes"


def harms(whole: bytes) -> Iterator[bytes]:
    for place in [*range(120), *range(120, len(whole), 97)]:
        yield whole[:place] + bytes([whole[place] ^ (1 << place % 8)]) + whole[place + 1 :]
        yield whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :]
    for length in (0, 1, 15, 16, 17, 99, 100, 101, 4095, 4096, 4097, len(whole) - 1):
        yield whole[:length]
    yield bytes(len(whole))


def test_the_format_s_number_is_the_latest() -> None:
    assert VERSION == 2
