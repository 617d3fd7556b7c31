"""A station that is skipped is given up for good: a restart does not go back to it."""

from __future__ import annotations

from pathlib import Path

from navigation.journal.journal import Journal, owner_of
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.orders.carry_out import carry_out
from navigation.run.virtual_world import VirtualWorld
from tests.support.runs.virtual import cycle_until, is_driving, short_config

FAR, NEAR = {"x_m": 0.2, "y_m": 1.6}, {"x_m": 0.9, "y_m": 0.3}


def test_what_is_skipped_is_skipped_for_a_restart_too(tmp_path: Path) -> None:
    config = short_config([FAR, NEAR])
    journal = Journal(tmp_path / "journal", owner_of(config))
    world = VirtualWorld(config, pictures=False)
    far, near = stations_of(config)
    with journal, Daemon(config, world, first_mission_id=7, journals={"": journal}) as daemon:
        daemon.people.give((far, near))
        cycle_until(daemon, is_driving)
        assert carry_out({"order": "skip"}, daemon.people)["ok"]
        cycle_until(daemon, lambda now: now.mission.stations == (near,))
        left = journal.unfinished()
        assert left is not None
        assert left.stations == (near,)
        done = cycle_until(daemon, lambda now: now.mission.is_over)
        assert (done.mission.state, done.mission.visited) == (State.DONE, 1)


def test_a_mission_whose_only_station_is_skipped_is_over_for_a_restart_too(tmp_path: Path) -> None:
    config = short_config([FAR])
    path = tmp_path / "journal"
    world = VirtualWorld(config, pictures=False)
    with (
        Journal(path, owner_of(config)) as journal,
        Daemon(config, world, first_mission_id=7, journals={"": journal}) as daemon,
    ):
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        assert carry_out({"order": "skip"}, daemon.people)["ok"]
        done = cycle_until(daemon, lambda now: now.mission.is_over)
        assert done.sentence.startswith("the last station, at (0.2, 1.6) m, was skipped")
        cycle_until(daemon, lambda now: not now.link.moving)
        stood = world.truths[""].track()[-1][1:3]
        for _ in range(60):
            daemon.cycle()
        assert abs(world.truths[""].track()[-1][1:3] - stood).max() < 1e-3
        refused = carry_out({"order": "skip"}, daemon.people)
        assert "no station is left" in refused["error"]
    with Journal(path, owner_of(config)) as journal:
        assert journal.unfinished() is journal.rearmed() is None
        kept = journal.mission()
        assert kept is not None
        assert (kept.state, kept.stations) == (State.DONE, ())
