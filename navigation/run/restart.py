"""What a restarted program goes on with: the journal's mission, and what the robot did meanwhile.

Seconds of the daemon's clock.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from navigation.journal.journal import Journal
from navigation.loop.daemon import Daemon
from navigation.mission.mission import Mission

ROBOT_PATIENCE_S: Final = 3.0
"""How long a restart waits for the robot to say how far it has come."""


def unfinished_mission(
    daemon: Daemon, journal: Journal, interrupted: Callable[[], bool] = lambda: False
) -> Mission | None:
    """The mission that was going on when the last program ended; None where there was none.

    A robot that still holds the plan that it was given last tells how many waypoints of it it
    has executed, some perhaps after the journal's last entry. One that has lost it, by a power
    cycle, or does not answer leaves the journal's word: it is planned for anew from where the
    camera sees it.
    """
    mission, plan = journal.unfinished(), journal.plan()
    if mission is None or plan is None:
        return mission
    until_s = daemon.world.clock() + ROBOT_PATIENCE_S
    while daemon.world.clock() < until_s and not interrupted():
        daemon.cycle()
        snapshot = daemon.robot.link.snapshot()
        if snapshot.down_reason is not None or snapshot.status is None:
            continue
        if snapshot.mission_id != plan.mission_id:
            break
        visited = min(plan.visited_after(snapshot.executed), len(mission.stations) - 1)
        return mission.with_visited(max(mission.visited, visited))
    return mission
