"""A daemon that only shows: the dashboard's tests set its state and look at its orders.

It has a mission and a link that answer orders as those of a real run do, at once; its robot stays
where it is. Its clock stands still between two cycles: nothing goes stale, and nothing hangs,
because a computer is busy.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import planner
from firmware_protocol.host.state import LinkState
from navigation.config import Config, parse_config
from navigation.config.zones import ZoneSection
from navigation.dashboard.messages.geometry import world_message
from navigation.dashboard.messages.heat import heat_message
from navigation.link.serial_link import LinkSnapshot
from navigation.loop.run_state import RobotSnapshot, RunState, StageTimes
from navigation.loop.zones_in_force import ZonesInForce
from navigation.mission.cycle import PlanAnswer
from navigation.mission.mission import (
    TRANSITIONS,
    Event,
    MissionError,
    MissionProgress,
    State,
    Station,
)
from navigation.mission.watch import Action, Verdict
from planner.formats.scene_io import load_scene
from planner.path import Limits, NoPath
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds
from planner.zones.zoned_roadmap import with_zones
from tests.support.people import RecordedPeople
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame
from vision.camera.latest_frame import CameraStatus
from vision.markers.markers import RobotPose

ROOT = Path(__file__).parents[3]
RADIUS_M = 0.09
LIMITS = Limits(0.3, 0.5, 0.4, 2.0, 6.0, 5.0, 0.05, 0.002, 0.2, 0.12)
SIZE_PX = (480, 360)
SCALE_M = 0.005
"""A plan to scale: 480 x 360 pixels of 5 mm are the arena of 2.4 m x 1.8 m."""
CYCLE_S = 0.1


def shown_config(**dashboard: object) -> Config:
    """The shipped simulation with a camera that is a plan to scale, its page at a free port."""
    text = (ROOT / "configs/simulation.yaml").read_text()
    lines = {"port": 0, "picture_width_px": 160, **dashboard}
    text += "\ndashboard:\n" + "".join(f"  {key}: {value}\n" for key, value in lines.items())
    return parse_config(text, "shown.yaml", ROOT / "configs", {})


@cache
def laboratory() -> Roadmap:
    """The roadmap of the arena of the shipped simulation.

    What the page shows of it is compiled and loaded, so that no page has to wait for that.
    """
    scene = load_scene(ROOT / "configs/arenas/laboratory.txt")
    roadmap = planner.build_roadmap(scene, RADIUS_M)
    zoned = with_zones(roadmap, ())
    world_message(zoned, 1)
    heat_message(zoned, Bounds(0.0, 0.0, 2.4, 1.8), 1)
    path = roadmap.plan((0.2, 0.2), (0.3, 1.5))
    assert not isinstance(path, NoPath)
    planner.time_path(path, LIMITS)
    return roadmap


def frame(number: int, captured_s: float = 0.0) -> Frame:
    """A picture with a slope, and a bright square at (0, 0) m, so that it can be told apart."""
    width, height = SIZE_PX
    image = np.tile(np.linspace(40, 200, width).astype(np.uint8), (height, 1))
    image[-20:, :20] = 255
    image[0, 0] = number % 256
    return Frame(image, captured_s, number, "a test")


def pose(x: float = 0.2, y: float = 0.2, heading_rad: float = 0.5) -> RobotPose:
    """The driven robot."""
    corner = np.array([[x / SCALE_M - 0.5, (1.8 - y) / SCALE_M - 0.5]])
    return RobotPose(7, x, y, heading_rad, 0.0, np.repeat(corner, 4, axis=0))


class FakeDaemon:
    """Shows what a test sets; its ``people`` take orders, and ``orders`` has them."""

    def __init__(self, config: Config | None = None, roadmap: Roadmap | None = None) -> None:
        self.config = config or shown_config()
        self.calibration = Calibration.from_scale(SCALE_M, SIZE_PX)
        self.camera = CameraStatus("running", "", 30.0, 100, 1, 0, 0.01)
        self.lent: str | None = None
        """Why the robot has to hold: a calibration has the camera; None where it has not."""
        self.turn = threading.RLock()
        self.zones = ZonesInForce(self.config.zones, ())
        self.people = _Acting(self, roadmap)
        self.orders = self.people.orders
        self.robot: RobotSnapshot | None = RobotSnapshot(
            time_s=1.0,
            mission=MissionProgress(),
            sentence="no mission was given",
            pose=pose(),
            link=LinkSnapshot(LinkState.STREAM, None, 0.02, status_age_s=0.02),
            to_go_m=None,
            clearance_m=0.2,
            verdict=Verdict(Action.GO, ()),
            frame=frame(1),
            poses={7: pose()},
            roadmap=roadmap,
            path=None,
            times=StageTimes(0.005, 0.02, None, 0.009),
        )
        self._published: tuple[RobotSnapshot, RunState] | None = None

    @property
    def state(self) -> RunState | None:
        """As a daemon's: the same object until something is shown."""
        if self.robot is None:
            return None
        if self._published is None or self._published[0] is not self.robot:
            self._published = self.robot, RunState(self.robot.time_s, {"": self.robot})
        return self._published[1]

    def show(self, **changes: Any) -> None:
        """A new state, as after a cycle."""
        with self.turn:
            assert self.robot is not None
            if "mission" in changes:
                changes.setdefault("sentence", changes["mission"].reason)
            self.robot = replace(self.robot, **changes)

    def cycle(self) -> None:
        """Let a tenth of a second pass, with a picture at its end."""
        with self.turn:
            assert self.robot is not None
            now_s = self.clock() + CYCLE_S
            seen = replace(pose(), captured_s=now_s)
            picture = frame(round(now_s / CYCLE_S), now_s)
            self.show(time_s=now_s, frame=picture, pose=seen, poses={7: seen})

    def clock(self) -> float:
        """Seconds, of which cycles are made."""
        return 0.0 if self.robot is None else self.robot.time_s

    @property
    def mission(self) -> MissionProgress:
        """What it does."""
        assert self.robot is not None
        return self.robot.mission

    @property
    def frame(self) -> Frame | None:
        """The newest picture."""
        return None if self.robot is None else self.robot.frame

    def camera_status(self) -> CameraStatus:
        return self.camera

    def become(self, mission: MissionProgress, **changes: Any) -> None:
        """Another mission, and its robot moves or is stopped as it says."""
        assert self.robot is not None
        link = replace(
            self.robot.link,
            moving=mission.state is State.DRIVING,
            estopped=mission.state is State.STOPPED,
        )
        self.show(mission=mission, link=link, **changes)


class _Acting(RecordedPeople):
    """Notes every order, and acts at once on those whose effect the page's tests look at."""

    def __init__(self, daemon: FakeDaemon, roadmap: Roadmap | None) -> None:
        super().__init__()
        self._daemon, self._roadmap = daemon, roadmap

    def preview(self, stations: tuple[Station, ...], robot: str | None = None) -> PlanAnswer:
        assert self._roadmap is not None
        *vias, goal = [(one.x, one.y) for one in stations]
        path = self._roadmap.plan((0.2, 0.2), goal, via=vias)
        if isinstance(path, NoPath):
            return PlanAnswer(1, 1, path)
        return PlanAnswer(1, 1, path, planner.time_path(path, LIMITS))

    def give(self, stations: tuple[Station, ...], robot: str | None = None) -> None:
        if self._daemon.lent is not None:
            raise MissionError(self._daemon.lent)
        if any(station.x > 5.0 for station in stations):
            raise MissionError("station 1 at (9, 9) m: outside the arena")
        with self._daemon.turn:
            mission = self._daemon.mission.given(stations, "a mission was given")
            self.orders.append(("give", stations))
            self._begin(mission)

    def stop(self, reason: str, robot: str | None = None) -> None:
        with self._daemon.turn:
            self.orders.append(("stop", reason))
            self._daemon.become(self._daemon.mission.after(Event.STOP, reason))

    def pause(self, robot: str | None = None) -> None:
        with self._daemon.turn:
            self.orders.append(("pause",))
            mission = replace(self._daemon.mission, paused=True)
            if (mission.state, Event.HOLD) in TRANSITIONS:
                mission = mission.after(Event.HOLD, "paused by the operator")
            self._daemon.become(mission)

    def resume(self, robot: str | None = None) -> None:
        with self._daemon.turn:
            self.orders.append(("resume",))
            mission = replace(self._daemon.mission, paused=False)
            if mission.state is State.STOPPED:
                self._daemon.become(mission.after(Event.REARM, "re-armed by hand"))
            elif mission.state is State.HOLDING:
                self._begin(mission.after(Event.CLEARED, "resumed"))
            else:
                self._daemon.become(mission)

    def put_zone(self, zone: ZoneSection) -> None:
        self.orders.append(("put_zone", zone.name))
        self._daemon.zones.put(zone)

    def remove_zone(self, name: str) -> None:
        self.orders.append(("remove_zone", name))
        self._daemon.zones.remove(name)

    def undo_zone(self, seen: int | None) -> None:
        self.orders.append(("undo_zone",))
        self._daemon.zones.undo(seen)

    def describe(self, robot: str | None = None) -> Mapping[str, Any]:
        mission = self._daemon.mission
        return {"state": mission.state.value, "reason": mission.reason}

    def _begin(self, mission: MissionProgress) -> None:
        """Plan, and drive where there is a path."""
        path = None if self._roadmap is None else self.preview(mission.remaining).path
        if isinstance(path, NoPath):
            self._daemon.become(mission.after(Event.NO_PLAN, path.reason))
        else:
            self._daemon.become(mission.after(Event.PLANNED, "driving"), path=path)
