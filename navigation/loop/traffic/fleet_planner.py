"""The fleet's planner beside the control loop: the newest roadmap, and promises for all."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import replace

from navigation.config import Config
from navigation.fleet.joining import join_promises
from navigation.fleet.planning import plan_promises
from navigation.fleet.request import FleetAnswer, FleetRequest, Traveller
from navigation.loop.planning import ArenaPlanner
from navigation.loop.stages import plan_settings
from navigation.mission.cycle import PlanAnswer, PlanRequest
from navigation.shared.supervisor import in_words
from planner.path import NoPath
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Scene, Vec
from planner.shared.search_clock import Clock, search_clock_s
from planner.zones.rules import Rules, rules_for
from planner.zones.zone import Zone, zones_for


class FleetPlanner:
    """Keeps the smallest robot's roadmap of the newest scene, and answers with it."""

    def __init__(self, configs: dict[str, Config], clock: Clock = search_clock_s) -> None:
        self._clock = clock
        smallest = min(configs.values(), key=lambda config: config.robot.radius_m)
        self._arena = ArenaPlanner(plan_settings(smallest))  # without zones
        self._keep_m = min(config.safety.other_robots_m for config in configs.values())
        self._seen: tuple[Roadmap, Scene, int, tuple[Zone, ...]] | None = None
        """Newest scene with its roadmap, revision and zones: threads read it as a whole."""
        self._previewing = threading.Lock()
        self._rules: dict[str, Rules] = {}
        self._alone = {
            name: ArenaPlanner(plan_settings(one), name) for name, one in configs.items()
        }
        """For previews, brought up to date when asked."""

    @property
    def roadmap(self) -> Roadmap | None:
        """Newest roadmap; None before the first scene."""
        return self._arena.roadmap

    @property
    def revision(self) -> int:
        """Revision of the newest scene; 0 before the first."""
        return self._arena.revision

    def see(self, scene: Scene, revision: int, zones: Sequence[Zone] = ()) -> None:
        """Take over a new scene and its zones."""
        self._arena.see(scene, revision)
        assert self._arena.roadmap is not None
        self._seen = self._arena.roadmap, scene, revision, tuple(zones)
        self._rules = {
            name: rules_for(zones_for(zones, name), scene, one.settings.radius_m)
            for name, one in self._alone.items()
        }

    def rules(self, robot: str) -> Rules | None:
        """Zones for a robot in the newest scene; None before the first."""
        return self._rules.get(robot)

    def path_clearance_m(self, points: FloatArray) -> float | None:
        """Exact clearance of a polyline in the newest scene; None before the first."""
        return self._arena.path_clearance_m(points)

    def clearance_m(self, position: Vec) -> float | None:
        """Exact clearance of a place in the newest scene; None before the first."""
        return self._arena.clearance_m(position)

    def preview(self, robot: str, request: PlanRequest) -> PlanAnswer:
        """Return one robot's plan as if it were alone."""
        planner = self._alone[robot]
        with self._previewing:
            if self._seen is not None and planner.revision != self._seen[2]:
                planner.see(*self._seen[1:])
            return planner.answer(request, preview=True)

    def answer(self, request: FleetRequest) -> FleetAnswer:
        """Return promises for all that can move; an error of the planner refuses everyone."""
        names = [one.name for one in request.travellers]
        if self._seen is None:
            return FleetAnswer(request.id, 0, {}, dict.fromkeys(names, "no scene was seen yet"))
        roadmap, scene, revision, zones = self._seen
        try:
            orders = {one.name: self._best_order(one) for one in request.travellers}
            travellers = tuple(_bound_first(one, orders[one.name]) for one in request.travellers)
            request = replace(
                request,
                travellers=tuple(_with_zones(one, zones) for one in travellers),
                idle=tuple(_with_zones(one, zones) for one in request.idle),
                driving=tuple(
                    replace(one, zones=zones_for(zones, one.promise.name))
                    for one in request.driving
                ),
            )
            plan = join_promises if request.driving else plan_promises
            answer = plan(roadmap, scene, request, self._keep_m, self._clock)
        except Exception as error:  # noqa: BLE001 - said where the answer is, which is asked again
            why = f"the planner failed on this request ({in_words(error)})"
            return FleetAnswer(request.id, revision, {}, dict.fromkeys(names, why))
        promises = {
            name: replace(one, path=replace(one.path, order=orders.get(name, ())))
            for name, one in answer.promises.items()
        }
        return replace(answer, promises=promises, scene_revision=revision)

    def _best_order(self, one: Traveller) -> tuple[int, ...]:
        """Shortest order of its stations but the last if alone; else as written."""
        stations = one.open_order
        if len(stations) < 3:
            return tuple(range(len(stations) - 1))
        request = PlanRequest(0, one.start, stations, self.revision, any_order=True)
        path = self.preview(one.name, request).path
        return tuple(range(len(stations) - 1)) if isinstance(path, NoPath) else path.order


def _with_zones(one: Traveller, zones: Sequence[Zone]) -> Traveller:
    return replace(one, zones=zones_for(zones, one.name))


def _bound_first(one: Traveller, order: tuple[int, ...]) -> Traveller:
    return replace(one, station=one.open_order[order[0]]) if order else one
