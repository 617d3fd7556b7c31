"""Zones that people changed hold after a restart; where they are lost, nothing drives."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import pytest

from navigation.config import Config
from navigation.journal import kept_zones
from navigation.journal.kept_stops import KeptStops
from navigation.loop.daemon import Daemon
from navigation.machine.logs import EventLog, RunLog
from navigation.mission.mission import State
from navigation.run.give_missions import GiveMissions
from navigation.run.restoring_zones import RestoredZones
from navigation.run.runner import Runner
from navigation.run.virtual_world import VirtualWorld
from tests.navigation.journal.kept import circle
from tests.support.runs.virtual import cycle_until, is_driving, short_config

GOAL = [{"x_m": 0.9, "y_m": 0.3}]
CORNER = circle("corner", x_m=2.2)


def config_in(folder: Path) -> Config:
    return short_config(GOAL, recording={"journal": folder / "kept" / "journal"})


def begin(daemon: Daemon, folder: Path) -> list[str]:
    """What the runner does, in virtual time; return what it says."""
    said: list[str] = []
    log = RunLog(EventLog(None, None, now=datetime.now))
    zones = RestoredZones(daemon, said.append, log)
    stops = KeptStops(folder / "stops", folder / "c.sock", None, {"": ()})
    daemon.stopping.hold_from_before([daemon.robot], stops)
    zones.settle()
    GiveMissions(daemon, lambda _line: None)
    return said


def a_run(folder: Path) -> Daemon:
    config = config_in(folder)
    return Daemon(config, VirtualWorld(config, pictures=False), first_mission_id=1)


def test_a_zone_drawn_before_a_kill_holds_in_the_next_run(tmp_path: Path) -> None:
    with a_run(tmp_path) as first:
        assert begin(first, tmp_path) == []
        first.people.put_zone(CORNER)
    # killed here
    with a_run(tmp_path) as second:
        said = begin(second, tmp_path)
        assert said == ["zone 'corner', added while an earlier run was under way: holds again"]
        assert second.zones.sections == (CORNER,)
        cycle_until(second, is_driving)


@pytest.mark.parametrize("damage", ["a byte lost", "empty", "a folder"])
def test_no_robot_drives_before_a_person_resumes_where_zones_are_lost(
    tmp_path: Path, damage: str
) -> None:
    with a_run(tmp_path) as first:
        begin(first, tmp_path)
        first.people.put_zone(CORNER)
    file = tmp_path / "kept" / "journal.zones"
    if damage == "a folder":
        file.unlink()
        file.mkdir()
    else:
        file.write_bytes(b"" if damage == "empty" else file.read_bytes()[:-1])
    for _ in range(2):  # the stop outlives a further restart, in which nothing is damaged
        with a_run(tmp_path) as again:
            begin(again, tmp_path)
            end_s = again.world.clock() + 5.0
            while again.world.clock() < end_s:
                now = again.cycle().only
                assert now.mission.state is State.STOPPED
            assert "changes of zones are lost" in now.sentence
            assert str(file) in now.sentence
            assert again.zones.sections == ()
            truth = again.world.truths[""].track()
            assert abs(truth[-1][1:3] - truth[0][1:3]).max() < 1e-3
        if damage == "a folder" and file.exists():
            file.rmdir()
    with a_run(tmp_path) as last:
        begin(last, tmp_path)
        last.cycle()
        last.people.resume()
        last.people.resume()
        cycle_until(last, is_driving)


def test_a_run_killed_before_its_stop_is_on_the_disk_stops_the_next_one_too(
    tmp_path: Path,
) -> None:
    with a_run(tmp_path) as first:
        begin(first, tmp_path)
        first.people.put_zone(CORNER)
    file = tmp_path / "kept" / "journal.zones"
    file.write_bytes(file.read_bytes()[:-1])
    with a_run(tmp_path) as killed:
        RestoredZones(killed, print, RunLog(EventLog(None, None, now=datetime.now)))
    # killed here
    with a_run(tmp_path) as again:
        said = begin(again, tmp_path)
        again.cycle()
        assert again.robot.pilot.mission.state is State.STOPPED
        assert said[-1] == f"{file}: kept as {file.name}.damaged-1"
        again.people.put_zone(CORNER)
    with a_run(tmp_path) as last:
        begin(last, tmp_path)
        assert last.zones.sections == (CORNER,)
        assert last.robot.pilot.mission.state is State.STOPPED


def test_the_runner_restores_zones_and_says_so(tmp_path: Path) -> None:
    with a_run(tmp_path) as first:
        begin(first, tmp_path)
        first.people.put_zone(CORNER)
    said: list[str] = []
    config = config_in(tmp_path)
    recording = config.recording.model_copy(update={"runs_dir": tmp_path / "runs"})
    runner = Runner(
        config.model_copy(update={"recording": recording}),
        once=True,
        say=said.append,
        socket=tmp_path / "socket",
        dashboard=False,
    )
    runner.waits = True
    runner.run()
    assert "zone 'corner', added while an earlier run was under way: holds again" in said


def test_where_the_stop_cannot_be_written_the_damage_stops_the_next_run(tmp_path: Path) -> None:
    file = tmp_path / "kept" / "journal.zones"
    file.parent.mkdir()
    file.write_bytes(b"torn")
    (tmp_path / "stops").write_text("in the way")
    for _ in range(2):
        with a_run(tmp_path) as again:
            begin(again, tmp_path)
            again.cycle()
            assert again.robot.pilot.mission.state is State.STOPPED
            assert file.read_bytes() == b"torn"


def test_a_damaged_file_that_cannot_be_put_aside_is_kept_and_changes_say_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next change was written over it, and until then no answer said that it was not kept."""
    monkeypatch.setattr(kept_zones, "MOST_ASIDE", 1)
    file = tmp_path / "kept" / "journal.zones"
    file.parent.mkdir()
    file.write_bytes(b"torn")
    file.with_name("journal.zones.damaged-1").write_bytes(b"before")
    for _ in range(2):
        with a_run(tmp_path) as again:
            said = begin(again, tmp_path)
            assert said[-1] == f"{file}: cannot be put aside: 1 files are kept already"
            answer = again.people.put_zone(CORNER)
            assert not answer["kept"]
            assert "a restart would not know of this change" in answer["trouble"]
            again.cycle()
            assert answer["trouble"] in again.cycle().only.troubles
        assert file.read_bytes() == b"torn"
    file.unlink()
    with a_run(tmp_path) as last:
        begin(last, tmp_path)
        assert "trouble" not in last.people.put_zone(CORNER)
