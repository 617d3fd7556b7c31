"""The report of a run: each robot's own, and the least gap between two robots."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from navigation.config.secrecy.secrets import hide_in
from navigation.config.zones.in_words import as_written
from navigation.loop.daemon import Daemon
from navigation.mission.mission import State
from navigation.run.robot_report import Report
from navigation.run.summary import summarise
from navigation.shared.whole_file import write_whole
from planner.fleet.motions.track_kernels import nearest_pair


@dataclass(frozen=True, slots=True)
class RunReport:
    """Summary of one run; None for an unknown value.

    A single robot has the empty name; files and people get its report alone.
    """

    state: str
    reason: str
    duration_s: float
    robots: Mapping[str, Report]
    least_gap_m: float | None = None
    """Between the two bodies that came nearest; below 0 they touched."""
    least_gap_between: tuple[str, str] | None = None
    min_clearance_m: float | None = None
    """Least distance of a robot's centre to an obstacle, over all robots."""
    rounds: int = 0
    """Number of plans asked for."""
    zones: tuple[Mapping[str, Any], ...] = ()
    """Zones in force at the end, as a configuration has them."""

    @classmethod
    def of_nothing(cls, reason: str, stations: Mapping[str, int]) -> RunReport:
        """Make the report of a run that ended before it had its devices."""
        robots = {name: Report.of_nothing(reason, count) for name, count in stations.items()}
        return cls(State.STOPPED.value, reason, 0.0, robots)

    @property
    def only(self) -> Report:
        """Report of a run's only robot."""
        (report,) = self.robots.values()
        return report

    def as_json(self) -> dict[str, Any]:
        """Return the report in JSON's types."""
        if "" in self.robots:
            return {**asdict(self.only), "zones": list(self.zones)}
        return {
            "state": self.state,
            "reason": self.reason,
            "duration_s": self.duration_s,
            "least_gap_m": self.least_gap_m,
            "least_gap_between": self.least_gap_between,
            "min_clearance_m": self.min_clearance_m,
            "rounds": self.rounds,
            "zones": list(self.zones),
            "robots": {name: asdict(report) for name, report in self.robots.items()},
        }

    def to_json(self) -> str:
        """Return one JSON object; numbers are finite or null."""
        return json.dumps(hide_in(self.as_json()), indent=2, allow_nan=False)

    def write(self, path: Path) -> None:
        """Write the JSON file; ``UnwrittenFileError`` on failure."""
        write_whole(path, self.to_json() + "\n")

    def lines(self) -> list[tuple[str, str]]:
        """Return pairs of label and value, for a person."""
        if "" in self.robots:
            return self.only.lines()
        gap = "unknown"
        if self.least_gap_m is not None and self.least_gap_between is not None:
            a, b = self.least_gap_between
            gap = f"{self.least_gap_m * 1e3:.1f} mm, between {a} and {b} (ground truth)"
        return [
            ("state", f"{self.state}: {self.reason}"),
            ("least gap", gap),
            ("duration", f"{self.duration_s:.1f} s"),
            ("planned together", f"{self.rounds} times"),
            *((name, report.in_short()) for name, report in self.robots.items()),
        ]


def summarise_run(daemon: Daemon, state: State, reason: str, duration_s: float) -> RunReport:
    """Make the report from what the daemon kept."""
    alone = "" in daemon.robots
    robots = {}
    for name, robot in daemon.robots.items():
        mission = robot.pilot.mission
        ended = (state, reason) if alone else (mission.state, mission.reason)
        robots[name] = summarise(daemon, robot, *ended, duration_s)
    gap = least_gap(daemon)
    clearances = [one.min_clearance_m for one in robots.values() if one.min_clearance_m is not None]
    return RunReport(
        state=state.value if state in (State.DONE, State.FAILED) else State.STOPPED.value,
        reason=reason,
        duration_s=duration_s,
        robots=robots,
        least_gap_m=None if gap is None else gap[0],
        least_gap_between=None if gap is None else gap[1:],
        min_clearance_m=min(clearances, default=None),
        rounds=daemon.traffic.rounds,
        zones=tuple(as_written(one) for one in daemon.zones.sections),
    )


def least_gap(daemon: Daemon) -> tuple[float, str, str] | None:
    """Least gap between two bodies by the ground truth, and their names; None with fewer than two.

    Between two known places, 20 ms apart, both move straight and evenly.
    """
    names, tracks = [], []
    for name, truth in daemon.world.truths.items():
        track = truth.track()
        if len(track):
            names.append(name)
            tracks.append(np.ascontiguousarray(track[:, :3]))
    if len(names) < 2:
        return None
    radii = np.array([daemon.robots[name].config.robot.radius_m for name in names])
    first = np.concatenate([[0], np.cumsum([len(track) for track in tracks])]).astype(np.int64)
    gap_m, i, j, _ = nearest_pair(np.concatenate(tracks), first, radii)
    return float(gap_m), names[int(i)], names[int(j)]
