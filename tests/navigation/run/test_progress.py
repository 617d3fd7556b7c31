"""The lines about several robots: an emergency stop says its cause, whatever its robot was at."""

from __future__ import annotations

from navigation.config import Config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.run.progress import ProgressLines, why_stopped
from navigation.run.virtual_run import run_virtually
from tests.navigation.run.test_fleet_runs import CONFIGS, open_hall


def with_one_at_rest() -> Config:
    """Two robots, of which the second has no mission."""
    config = open_hall("a", "b", time_limit_s=4.0).model_dump(mode="json", exclude_none=True)
    config["mission"]["robots"].pop()
    return Config.model_validate(config, context={"folder": CONFIGS}, strict=False)


def test_each_robots_stop_is_one_line_with_its_cause_and_a_status_says_it() -> None:
    said: list[str] = []
    told: list[str] = []
    lines = ProgressLines(said.append, told.append)
    ends: list[RunState] = []

    def look(daemon: Daemon, now: RunState) -> bool:
        lines.cycle(now)
        ends.append(now)
        if len(ends) == 30:
            daemon.people.stop("a cat on the table")
        return len(ends) == 60

    run_virtually(with_one_at_rest(), look=look, pictures=False)
    stops = [line.split(maxsplit=4)[2:] for line in said if " stopped " in line]
    assert sorted(stops) == [[name, "stopped", "a cat on the table"] for name in "ab"]
    assert told[-1] == "stopped: a: a cat on the table"
    assert len(told) == len(set(told)) < len(said)
    assert why_stopped(ends[-1]) == "all robots: a cat on the table"
    assert why_stopped(ends[20]) is None
