"""The journal: nothing that was saved is lost, and a restart goes on where it was."""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.journal import Journal, JournalError, SentPlan
from navigation.mission import Event, Mission, State, Station
from navigation.targets import Target

numbers = st.floats(allow_nan=False, allow_infinity=False, width=64)
stations = st.builds(Station, numbers, numbers, st.none() | numbers, numbers)
targets = st.builds(
    Target, numbers, numbers, numbers, st.booleans(), st.none() | numbers, numbers,
    st.none() | st.integers(0, 99),
)  # fmt: skip
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


@given(missions, st.lists(targets, max_size=5), st.integers(1, 2**32 - 1))
def test_what_is_saved_is_read_back_exactly(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission, some: list[Target], number: int
) -> None:
    path = tmp_path_factory.mktemp("journal") / "journal.sqlite"
    plan = SentPlan(number, 1, tuple(some))
    with Journal(path) as journal:
        journal.save_mission(mission)
        journal.save_plan(plan)
    with Journal(path) as journal:
        assert journal.mission() == mission
        assert journal.plan() == plan


def test_only_an_unfinished_mission_is_gone_on_with(tmp_path: Path) -> None:
    two = (Station(1.0, 1.0), Station(2.0, 1.0))
    driving = Mission().given(two, "go").after(Event.PLANNED, "driving").with_visited(1)
    with Journal(tmp_path / "j") as journal:
        assert journal.unfinished() is None
        journal.save_mission(driving)
        assert journal.unfinished() == driving
        for event in (Event.STOP, Event.FAIL):
            journal.save_mission(driving.after(event, "over"))
            assert journal.unfinished() is None
        journal.save_mission(replace(driving, visited=2))
        assert journal.unfinished() is None


def test_the_robot_s_progress_counts_stations_of_the_plan_it_holds() -> None:
    row = tuple(
        Target(float(i), 0.0, 0.3, False, station=s) for i, s in enumerate([None, 1, None, 2])
    )
    plan = SentPlan(7, 3, row)
    assert [plan.visited_after(n) for n in range(5)] == [3, 3, 4, 4, 5]


def test_a_file_that_is_no_journal_is_refused_and_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("these are my notes, and quite long ones at that " * 50)
    before = path.read_bytes()
    with pytest.raises(JournalError, match=r"notes\.txt"):
        Journal(path)
    assert path.read_bytes() == before


def test_a_journal_of_a_later_version_is_refused(tmp_path: Path) -> None:
    import sqlite3

    path = tmp_path / "later"
    with sqlite3.connect(path) as db:
        db.execute("PRAGMA user_version=99")
    db.close()
    with pytest.raises(JournalError, match="version 99"):
        Journal(path)


WRITER = """
import sys
from pathlib import Path
from navigation.journal import Journal
from navigation.mission import Mission, State, Station
journal = Journal(Path(sys.argv[1]))
stations = tuple(Station(float(i), 0.0) for i in range(5000))
for visited in range(5000):
    journal.save_mission(Mission(stations[:50], visited % 51, False, State.DRIVING, str(visited)))
    print(visited, flush=True)
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
        with Journal(path) as journal:
            mission = journal.mission()
        assert mission is not None
        assert int(mission.reason) in (last, last + 1)
