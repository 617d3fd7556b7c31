"""The journal: nothing that was saved is lost, and nothing that cannot be trusted is driven."""

import json
import os
import signal
import sqlite3
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.journal import journal_file
from navigation.journal.journal import RETRY_S, Journal, JournalError, SentPlan, owner_of
from navigation.journal.journal_file import VERSION, JournalFile
from navigation.journal.journal_records import Contents, Owner, RecordError, from_text, to_text
from navigation.mission.mission import Event, Mission, State, Station
from navigation.mission.targets import Target
from tests.support.runs.virtual import short_config

OWNER = Owner(robot="7 of DICT_4X4_50", port="simulated", camera="a", configuration="/etc/a.yaml")
numbers = st.floats(-1e3, 1e3)
headings = st.none() | st.floats(-3.14, 3.14)
dwells = st.floats(0.0, 3600.0)
stations = st.builds(Station, numbers, numbers, headings, dwells)
targets = st.builds(
    Target, numbers, numbers, st.floats(0.0, 5.0), st.booleans(), headings, dwells, st.none()
)
missions = st.lists(stations, min_size=1, max_size=5).flatmap(
    lambda s: st.builds(
        Mission,
        st.just(tuple(s)),
        st.integers(0, len(s)),
        st.booleans(),
        st.sampled_from(State),
        st.text(max_size=20),
    )
)
TWO = (Station(1.0, 1.0), Station(2.0, 1.0))
DRIVING = Mission().given(TWO, "go").after(Event.PLANNED, "driving").with_visited(1)
PLAN = SentPlan(9, 0, (Target(1.0, 1.0, 0.3, True, station=1), Target(2.0, 1.0, 0.0, True)))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal"


def keep(path: Path, mission: Mission = DRIVING, plan: SentPlan | None = PLAN) -> None:
    with Journal(path, OWNER) as journal:
        journal.keep(mission, plan, 0.0)
        assert journal.trouble == ""


def aside(path: Path) -> list[str]:
    return sorted(file.name for file in path.parent.iterdir() if "-wal" not in file.name)


@given(missions, st.lists(targets, max_size=5), st.integers(1, 2**32 - 1))
def test_what_is_saved_is_read_back_exactly(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission, some: list[Target], number: int
) -> None:
    path = tmp_path_factory.mktemp("journal") / "journal.sqlite"
    plan = SentPlan(number, 0, tuple(some))
    keep(path, mission, plan)
    with Journal(path, OWNER) as journal:
        assert journal.mission() == mission
        assert journal.plan() == plan


def test_only_an_unfinished_mission_is_gone_on_with(path: Path) -> None:
    with Journal(path, OWNER) as journal:
        assert journal.unfinished() is None
        journal.keep(DRIVING, None, 0.0)
        assert journal.unfinished() == DRIVING
        for event in (Event.STOP, Event.FAIL):
            journal.keep(DRIVING.after(event, "over"), None, 0.0)
            assert journal.unfinished() is None
        journal.keep(replace(DRIVING, visited=2), None, 0.0)
        assert journal.unfinished() is None


def test_the_robot_s_progress_counts_stations_of_the_plan_it_holds() -> None:
    row = tuple(
        Target(float(i), 0.0, 0.3, False, station=s) for i, s in enumerate([None, 1, None, 2])
    )
    plan = SentPlan(7, 3, row)
    assert [plan.visited_after(n) for n in range(5)] == [3, 3, 4, 4, 5]


def test_the_plan_of_another_mission_is_forgotten_with_it(path: Path) -> None:
    """The robot's progress on the old plan says nothing about the new mission's stations."""
    with Journal(path, OWNER) as journal:
        journal.keep(DRIVING, PLAN, 0.0)
        journal.keep(DRIVING.with_visited(2), None, 0.0)
        assert journal.plan() == PLAN
        journal.keep(DRIVING.given((TWO[1], TWO[0]), "again"), None, 0.0)
        assert journal.plan() is None
    with Journal(path, OWNER) as journal:
        assert journal.plan() is None


# Whose it is.


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"robot": "8 of DICT_4X4_50"}, "the robot 7 of DICT_4X4_50, not 8 of DICT_4X4_50"),
        ({"port": "/dev/ttyUSB1"}, "the port simulated, not /dev/ttyUSB1"),
        ({"bounds_m": (0.0, 0.0, 1.0, 1.0)}, "the arena [-1000.0"),
        ({"configuration": "/etc/b.yaml"}, "the configuration /etc/a.yaml, not /etc/b.yaml"),
        ({"camera": "b"}, "another camera"),
    ],
)
def test_a_mission_of_another_robot_arena_or_configuration_is_never_driven(
    path: Path, other: dict[str, Any], words: str
) -> None:
    keep(path)
    with Journal(path, replace(OWNER, **other)) as journal:
        assert journal.unfinished() is None
        assert journal.plan() is None
        assert words in journal.remark
        assert "journal.other-1" in journal.remark
        assert "\n" not in journal.remark
    with Journal(path.with_name("journal.other-1"), OWNER) as journal:
        assert journal.unfinished() == DRIVING


def test_the_owner_follows_from_the_configuration_and_holds_no_password() -> None:
    config = short_config([])
    address = "rtsp://me:geheim-4711@host/live"
    seen = config.model_copy(
        update={"camera": config.camera.model_copy(update={"source": address})}
    )
    assert owner_of(config) != owner_of(seen)
    assert "geheim" not in str(owner_of(seen, Path("a.yaml")))
    assert owner_of(config, Path("a.yaml")) != owner_of(config, Path("b.yaml"))
    assert owner_of(config, Path("a.yaml")) == owner_of(short_config([]), Path("a.yaml"))


# Locks and rights.


def test_a_second_program_is_refused(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    second = (
        "import sys\nfrom pathlib import Path\nfrom navigation import journal_file\n"
        "from navigation.journal.journal import *\n"
        "try:\n    Journal(Path(sys.argv[1]), Owner())\n"
        "except JournalError as error:\n    print(error)\n"
    )
    with Journal(path, OWNER) as journal:
        journal.keep(DRIVING, PLAN, 0.0)
        told = subprocess.run(
            [sys.executable, "-c", second, str(path)], capture_output=True, text=True, check=True
        ).stdout
        assert f"journal {path}: is in use by another program" in told
        assert aside(path) == ["journal"]


@pytest.mark.parametrize("exists", [False, True])
def test_nobody_else_may_read_it(path: Path, exists: bool) -> None:
    before = os.umask(0)
    try:
        if exists:
            keep(path)
            path.chmod(0o666)
        with Journal(path, OWNER) as journal:
            journal.keep(DRIVING.with_visited(2), PLAN, 0.0)
            found = {f.name: stat.S_IMODE(f.stat().st_mode) for f in path.parent.iterdir()}
    finally:
        os.umask(before)
    assert {"journal", "journal-wal"} <= found.keys()
    assert set(found.values()) == {0o600}, found


def test_what_is_no_ordinary_file_is_refused(path: Path) -> None:
    path.mkdir()
    with pytest.raises(JournalError, match="no ordinary file"):
        Journal(path, OWNER)
    os.mkfifo(path.with_name("pipe"))
    with pytest.raises(JournalError, match="no ordinary file"):
        Journal(path.with_name("pipe"), OWNER)


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


# What goes wrong while it is used.


def test_a_journal_that_was_deleted_is_said_and_made_again(path: Path) -> None:
    with Journal(path, OWNER) as journal:
        journal.keep(replace(DRIVING, visited=0), PLAN, 0.0)
        for file in path.parent.iterdir():
            file.unlink()
        journal.keep(DRIVING, None, 1.0)
        assert "was deleted" in journal.trouble
        assert str(path) in journal.trouble
        journal.keep(DRIVING, None, 1.0 + RETRY_S)
        assert journal.trouble == ""
    with Journal(path, OWNER) as journal:
        assert (journal.mission(), journal.plan()) == (DRIVING, PLAN)


class FullDisk:
    """A connection whose writes find no room while ``full``."""

    def __init__(self, db: sqlite3.Connection) -> None:
        self._db, self.full, self.tries = db, True, 0

    def execute(self, statement: str, *values: Any) -> sqlite3.Cursor:
        if self.full and statement.startswith("INSERT"):
            self.tries += 1
            error = sqlite3.OperationalError("database or disk is full")
            error.sqlite_errorcode = sqlite3.SQLITE_FULL
            raise error
        return self._db.execute(statement, *values)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._db, name)


@pytest.fixture
def full_disk(monkeypatch: pytest.MonkeyPatch) -> list[FullDisk]:
    """Every connection that is opened, each on a full disk."""
    disks: list[FullDisk] = []
    connect = sqlite3.connect

    def opened(*arguments: Any, **options: Any) -> FullDisk:
        disks.append(FullDisk(connect(*arguments, **options)))
        return disks[-1]

    monkeypatch.setattr(journal_file.sqlite3, "connect", opened)
    return disks


def test_a_full_disk_is_said_and_tried_again_now_and_then(
    path: Path, full_disk: list[FullDisk]
) -> None:
    with Journal(path, OWNER) as journal:
        for tick in range(100):
            journal.keep(DRIVING, PLAN, 0.03 * tick)
        assert f"journal {path}: cannot be written: database or disk is full" in journal.trouble
        assert sum(disk.tries for disk in full_disk) <= 8
        full_disk[-1].full = False
        journal.keep(DRIVING.with_visited(2), None, 3.5)
        assert journal.trouble == ""


@pytest.mark.parametrize(
    ("now", "stays"),
    [
        (DRIVING, True),
        (DRIVING.after(Event.STOP, "stopped"), False),
        (replace(DRIVING, paused=True), False),
        (replace(DRIVING, state=State.DONE, visited=2), False),
        (DRIVING.given(TWO[::-1], "other"), False),
    ],
    ids=["progress", "stopped", "paused", "done", "replaced"],
)
def test_what_cannot_be_saved_never_leaves_a_record_that_drives_what_is_over(
    path: Path, full_disk: list[FullDisk], now: Mission, stays: bool
) -> None:
    with Journal(path, OWNER) as journal:
        full_disk[-1].full = False
        journal.keep(replace(DRIVING, visited=0), PLAN, 0.0)
        full_disk[-1].full = True
        journal.keep(now, None, 1.0)
        assert journal.trouble
        assert path.exists() == stays


def test_the_program_begins_on_a_full_disk_too(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_room(*_arguments: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(JournalFile, "_make_private", no_room)
        journal = Journal(path, OWNER)
        assert "No space left on device; the run goes on" in journal.trouble
        journal.keep(DRIVING, PLAN, 0.0)
        assert journal.trouble
    with journal:
        journal.keep(DRIVING, PLAN, 5.0)
        assert journal.trouble == ""
    with Journal(path, OWNER) as journal:
        assert journal.unfinished() == DRIVING


WRITER = """
import sys
from pathlib import Path
from navigation.journal.journal import Journal, Owner
from navigation.mission.mission import Mission, State, Station
journal = Journal(Path(sys.argv[1]), Owner())
stations = tuple(Station(float(i), 0.0) for i in range(50))
for number in range(5000):
    journal.keep(Mission(stations, number % 51, False, State.DRIVING, str(number)), None, 0.0)
    print(number, flush=True)
"""


def test_a_kill_at_any_moment_loses_nothing_that_was_saved(tmp_path: Path) -> None:
    for round_ in range(5):
        path = tmp_path / f"journal{round_}"
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True
        )
        assert writer.stdout is not None
        for _ in range(3 + 7 * round_):
            writer.stdout.readline()
        os.kill(writer.pid, signal.SIGKILL)
        said = writer.stdout.read().split()
        writer.stdout.close()
        writer.wait()
        last = int(said[-1]) if said else 2 + 7 * round_
        with Journal(path, Owner()) as journal:
            mission = journal.mission()
        assert mission is not None
        assert int(mission.reason) in (last, last + 1)


def test_the_format_s_number_is_the_latest() -> None:
    assert VERSION == 2
