"""What goes wrong with a journal while it is used: a deleted file, a full disk, a kill."""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from navigation.journal import journal_file
from navigation.journal.journal import RETRY_S, Journal
from navigation.journal.journal_file import JournalFile
from navigation.journal.journal_records import Owner
from navigation.mission.mission import Event, MissionProgress, State
from navigation.shared.whole_file import UnwrittenFileError, write_whole
from tests.navigation.journal.kept import DRIVING, OWNER, PLAN, TWO

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
    """What writes the journal; it finds no room while ``full``."""

    def __init__(self) -> None:
        self.full, self.tries = True, 0

    def write(self, path: Path, data: bytes, **options: bool) -> None:
        if self.full:
            self.tries += 1
            raise UnwrittenFileError(f"{path}: cannot be written: No space left on device")
        write_whole(path, data, **options)


@pytest.fixture
def full_disk(monkeypatch: pytest.MonkeyPatch) -> FullDisk:
    disk = FullDisk()
    monkeypatch.setattr(journal_file, "write_whole", disk.write)
    return disk


def test_a_full_disk_is_said_and_tried_again_now_and_then(path: Path, full_disk: FullDisk) -> None:
    with Journal(path, OWNER) as journal:
        for tick in range(100):
            journal.keep(DRIVING, PLAN, 0.03 * tick)
        assert f"journal {path}: cannot be written: No space left on device" in journal.trouble
        assert full_disk.tries <= 8
        full_disk.full = False
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
    path: Path, full_disk: FullDisk, now: MissionProgress, stays: bool
) -> None:
    with Journal(path, OWNER) as journal:
        full_disk.full = False
        journal.keep(replace(DRIVING, visited=0), PLAN, 0.0)
        full_disk.full = True
        journal.keep(now, None, 1.0)
        assert journal.trouble
        assert path.exists() == stays


def test_the_program_begins_on_a_full_disk_too(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_room(*_arguments: Any) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(JournalFile, "_take_lock", no_room)
        journal = Journal(path, OWNER)
        assert "No space left on device; the run continues" in journal.trouble
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
from navigation.mission.mission import MissionProgress, State, Station
journal = Journal(Path(sys.argv[1]), Owner())
stations = tuple(Station(float(i), 0.0) for i in range(50))
for number in range(5000):
    now = MissionProgress(stations, number % 51, False, State.DRIVING, str(number))
    journal.keep(now, None, 0.0)
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
