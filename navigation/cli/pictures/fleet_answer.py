"""The answer of ``clearway fleet``: as one JSON object (``clearway.fleet/1``) and as text.

Every field is present, null if it does not apply. Lengths are in the scene's units, times in
seconds from the common start, timings in milliseconds.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from navigation.cli.pictures.fleet_robots import FleetRobot
from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan

SCHEMA = "clearway.fleet/1"


@dataclass(frozen=True, slots=True)
class FleetOutput:
    """A fleet's plan, to be written in either form."""

    units: str
    robots: Sequence[FleetRobot]
    plan: FleetPlan | NoFleetPlan
    timings_ms: Mapping[str, float]
    remarks: tuple[str, ...] = ()

    def as_json(self) -> str:
        """Strict JSON, one line to a field."""
        return json.dumps(self.as_object(), allow_nan=False, indent=1)

    def as_object(self) -> dict[str, Any]:
        """Fields in the order in which they are written."""
        plan = self.plan
        planned = plan if isinstance(plan, FleetPlan) else None
        refused = None if isinstance(plan, FleetPlan) else plan
        who = None if refused is None else [self.robots[i].name for i in refused.blocking]
        return {
            "schema": SCHEMA,
            "status": "ok" if planned else "unreachable",
            "units": self.units,
            "robots": [self._robot(i) for i in range(len(self.robots))],
            "dependencies": self._dependencies(planned) if planned else None,
            "makespan_s": planned.makespan_s if planned else None,
            "flowtime_s": planned.flowtime_s if planned else None,
            "reason": self.sentence() if refused is not None else None,
            "blocking": who,
            "proved": refused.proved if refused is not None else None,
            "timings_ms": {name: round(ms, 3) for name, ms in self.timings_ms.items()},
            "remarks": list(self.remarks),
        }

    def _robot(self, i: int) -> dict[str, Any]:
        robot = self.robots[i]
        track = self.plan.tracks[i].tolist() if isinstance(self.plan, FleetPlan) else None
        return {
            "name": robot.name,
            "radius": robot.radius,
            "track": track,
            "arrival_s": self.plan.arrivals_s[i] if isinstance(self.plan, FleetPlan) else None,
        }

    def _dependencies(self, plan: FleetPlan) -> list[dict[str, Any]]:
        return [
            {
                "robot": self.robots[i].name,
                "passed": passed,
                "waiting": self.robots[j].name,
                "not_beyond": row,
            }
            for i, passed, j, row in plan.dependencies
        ]

    def sentence(self) -> str:
        """Reason why there is no plan, with the robots' names; else empty."""
        if isinstance(self.plan, FleetPlan):
            return ""
        head, colon, rest = self.plan.reason.partition(":")
        if not head.startswith("robot"):
            return self.plan.reason
        named = re.sub(r"\d+", lambda number: self.robots[int(number[0])].name, head)
        return f"{named}{colon}{rest}"

    def as_text(self) -> str:
        """The result for people, then each robot's track."""
        return "\n".join(self._lines()) + "\n"

    def _lines(self) -> Iterator[str]:
        if isinstance(self.plan, FleetPlan):
            last, total = self.plan.makespan_s, self.plan.flowtime_s
            yield f"{len(self.robots)} robots, the last arrives after {last:.6g} s"
            yield f"sum of arrivals {total:.6g} s, {len(self.plan.dependencies)} dependencies"
            for robot, track in zip(self.robots, self.plan.tracks, strict=True):
                yield f"{robot.name}: {len(track)} points, arrives after {track[-1, 0]:.6g} s"
                yield f"{'time':>12}{'x':>12}{'y':>12}"
                for t, x, y in track.tolist():
                    yield f"{t:12.3f}{x:12.5g}{y:12.5g}"
        else:
            yield f"no plan: {self.sentence()}"
        for remark in self.remarks:
            yield f"note: {remark}"
