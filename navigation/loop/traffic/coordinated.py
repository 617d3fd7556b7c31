"""Several robots: the coordinator's promises, and its input about each robot.

Metres, radians, seconds of the world's clock.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from navigation.config import limits_of
from navigation.config.known_robots import CLEARWAY, KNOWN_ROBOTS
from navigation.fleet.coordinator import Coordinator
from navigation.fleet.members import SEEN_S, Member
from navigation.fleet.orders import TrafficOrders
from navigation.fleet.request import Answer, FleetAnswer
from navigation.link.link_snapshot import LinkSnapshot
from navigation.loop.planning import SceneCheck
from navigation.loop.robot import ControlledRobot
from navigation.loop.seeing.eye_settings import reach_m, stop_s
from navigation.loop.traffic.fleet_planner import FleetPlanner
from navigation.loop.traffic.traffic import Decided, PathCheck, breach_of
from navigation.mission.cycle import Orders, PlanAnswer, PlanRequest
from navigation.mission.mission import State
from navigation.mission.traffic import STANDING_M_S
from planner.shared.search_clock import Clock

BRAKES_S: Final = 0.3
"""Beyond a lease: time on the line, and for wheels and camera to react."""
SEEN_FASTER: Final = 2.0
"""Factor by which stamps may make a robot that obeys seem faster: 1.66 where they jitter by 10 ms,
and 1.93 between the first two pictures, at 10 to 30 a second."""
STOOD_S: Final = 0.25
"""A robot that was seen without motion for this time is at rest."""


class Coordinated:
    """`Traffic` of a run with several robots."""

    def __init__(self, robots: Mapping[str, ControlledRobot], search_clock: Clock) -> None:
        self._robots = robots
        configs = {name: one.config for name, one in robots.items()}
        self.planner = FleetPlanner(configs, search_clock)
        self._coordinator = Coordinator(self.planner.path_clearance_m, self.planner.rules)
        self._answer: FleetAnswer | None = None
        self._zones_since = 0
        """Revision of the scene in which the zones changed last."""
        self.waits: Mapping[str, str] = {}
        self.waits_for: Mapping[str, str] = {}

    @property
    def rounds(self) -> int:
        """Number of plans asked for."""
        return self._coordinator.rounds

    def checked_points(self) -> None:
        """None: `checked` measures all paths."""

    def checked(self, checks: Sequence[SceneCheck]) -> Iterable[PathCheck]:
        """Yield the check of each driven path."""
        if not checks:
            return
        changed = [check.revision for check in checks if check.zones_changed]
        self._zones_since = max([self._zones_since, *changed])
        for name, one in self._robots.items():
            path = one.pilot.plan.path
            if path is not None:
                rules = self.planner.rules(name)
                breach = breach_of(one, rules, zones_changed=bool(changed))
                breach = breach or self._coordinator.breach(name)
                yield PathCheck(name, self.planner.path_clearance_m(path.points), breach)

    def take(self, answer: Answer | None) -> Mapping[str, PlanAnswer]:
        """Keep the planner's answer for the coordinator's step."""
        self._answer = answer if isinstance(answer, FleetAnswer) else None
        return {}

    def step(self, now_s: float, decided: Mapping[str, Decided], revision: int) -> TrafficOrders:
        """Run one cycle of the coordinator."""
        members = {
            name: member(one, now_s, decided[name].orders, decided[name].snapshot)
            for name, one in self._robots.items()
        }
        orders = self._coordinator.step(now_s, members, revision, self._answer, self._zones_since)
        self.waits, self.waits_for = orders.waits, orders.waits_for
        return orders

    def released(self, name: str) -> int | None:
        """Number of targets that the robot may be sent; 0 without a promise."""
        release = self._coordinator.release(name)
        return 0 if release is None else release.targets

    def forget(self, name: str) -> None:
        """Cancel the robot's promise."""
        self._coordinator.forget(name)

    def preview(self, name: str, request: PlanRequest) -> PlanAnswer:
        """Return one robot's plan alone; any thread may ask."""
        return self.planner.preview(name, request)


def member(robot: ControlledRobot, now_s: float, orders: Orders, snapshot: LinkSnapshot) -> Member:
    """The coordinator's input about a robot."""
    pose, pilot = robot.pose, robot.pilot
    body, safety = robot.config.robot, robot.config.safety
    age_s = now_s - robot.pose_arrived_s
    return Member(
        state=pilot.mission.state,
        pose=None if pose is None else (pose.x, pose.y, pose.heading_rad),
        pose_age_s=age_s,
        stands=_stands(robot, now_s, age_s, snapshot),
        at_large=_is_at_large(robot, age_s, snapshot),
        radius_m=body.radius_m,
        limits=limits_of(robot.config),
        max_deviation_m=safety.max_deviation_m,
        reach_m=reach_m(body, safety) + body.speed_m_s * _drives_on_s(robot, snapshot),
        executed=pilot.plan.executed if pilot.plan.path is not None else None,
        request=orders.request,
        sentence=pilot.mission.reason,
        obliging=_is_obliging(robot, age_s, snapshot),
        velocity=(0.0, 0.0, 0.0) if pose is None else (pose.vx, pose.vy, pose.turn_rate_rad_s),
        obeys=_obeys(robot, now_s),
        is_silent=snapshot.down_reason is not None,
        keep_m=safety.other_robots_m,
    )


def _is_obliging(robot: ControlledRobot, age_s: float, snapshot: LinkSnapshot) -> bool:
    mission = robot.pilot.mission
    at_rest = mission.state in (State.IDLE, State.DONE) and not mission.remaining
    well = snapshot.down_reason is None and not snapshot.estopped and not mission.paused
    return at_rest and well and age_s <= robot.config.safety.pose_stale_s


def _obeys(robot: ControlledRobot, now_s: float) -> bool:
    """True if it is no faster than it can be, braking since its lease ran out."""
    if robot.pose is None:
        return True
    body = robot.config.robot
    braked_s = now_s - robot.permitted_s - robot.config.safety.lease_s - BRAKES_S
    if braked_s <= 0.0:
        fastest = SEEN_FASTER * body.speed_m_s
    else:
        fastest = max(body.speed_m_s - body.acceleration_m_s2 * braked_s, 0.0)
    return math.hypot(robot.pose.vx, robot.pose.vy) <= fastest + STANDING_M_S


def _drives_on_s(robot: ControlledRobot, snapshot: LinkSnapshot) -> float:
    """Time that it drives on beyond its lease, which our firmware ends on the robot itself.

    A driver's lease ends with its cable, which leaves only the robot's own watchdog.
    """
    driver = robot.config.robot.driver
    if driver == CLEARWAY or snapshot.down_reason is None:
        return 0.0
    watchdog_s = KNOWN_ROBOTS[driver].watchdog_s
    return math.inf if watchdog_s is None else watchdog_s


def _is_at_large(robot: ControlledRobot, age_s: float, snapshot: LinkSnapshot) -> bool:
    """True if it is not seen and only its cable, which is out, could stop it.

    A robot seen at rest when it had nothing to drive by is still at rest.
    """
    if age_s <= SEEN_S or math.isfinite(_drives_on_s(robot, snapshot)):
        return False
    seen_s, safety = robot.pose_arrived_s, robot.config.safety
    permitted_s = robot.permitted_s + safety.lease_s + BRAKES_S
    return seen_s < max(permitted_s, robot.moved_s + STOOD_S)


def _stands(robot: ControlledRobot, now_s: float, age_s: float, snapshot: LinkSnapshot) -> bool:
    if robot.pose is None:
        return True  # unknown: the coordinator refuses to plan
    safety = robot.config.safety
    if age_s > safety.pose_stale_s:
        drives_on_s = _drives_on_s(robot, snapshot)
        if math.isinf(drives_on_s):
            return age_s > SEEN_S  # at large, and refused as a whole, or seen at rest
        braked_s = stop_s(robot.config.robot, safety) + drives_on_s
        return age_s > braked_s  # its lease has ended, and it has braked
    if snapshot.down_reason is None and snapshot.moving:
        return False
    return now_s - robot.moved_s > STOOD_S
