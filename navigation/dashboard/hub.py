"""The hub: reads the daemon's published state and makes the viewers' messages.

Rules
- Everything runs in the dashboard's event loop; slow work in a worker thread. The control loop and
  the hub never wait for each other.
- A message is made once for all viewers.
- Pictures are made only while somebody looks, once for each size that is looked at; all viewers
  together get at most ``PICTURES_S`` a second.
"""

from __future__ import annotations

import asyncio
import json
import math
import operator
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final

from navigation.config.secrecy.secrets import hide_in
from navigation.dashboard.admission.access import AccessGate, Role
from navigation.dashboard.admission.seat import Seat
from navigation.dashboard.attention import EARLY, Attention
from navigation.dashboard.chronicles import Chronicles
from navigation.dashboard.kept.places import PlaceError, SavedPlaces, places_file
from navigation.dashboard.messages.camera_view import CameraView
from navigation.dashboard.messages.chronicle import COLUMNS
from navigation.dashboard.messages.geometry import plan_message, plans_message, world_message
from navigation.dashboard.messages.heat import heat_message
from navigation.dashboard.messages.packed import Made, pack
from navigation.dashboard.messages.picture import TopView
from navigation.dashboard.messages.state_message import (
    greeting,
    preview_facts,
    robot_facts,
    robots_greeting,
    state_message,
)
from navigation.dashboard.messages.zones import zones_message
from navigation.dashboard.orders import give
from navigation.dashboard.shown import IT_IS_A_RECORDING, Shown
from navigation.loop.run_state import RobotSnapshot, RunState
from navigation.mission.mission import MissionError, Station
from planner.path import Path
from planner.roadmap.roadmap import Roadmap
from planner.scene import Bounds
from planner.zones.zone import zones_for
from planner.zones.zoned_roadmap import ZonedRoadmap, with_zones
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

LOOK_EVERY_S: Final = 1.0 / 60.0
IDLE_EVERY_S: Final = 0.1
STATE_EVERY_S: Final = 0.1
PICTURES_S: Final = 120.0
KINDS: Final = ("picture", "camera")
MOST_VIEWERS: Final = 64
LOOP_DEAD_S: Final = 1.0
"""A control loop that ended no cycle for longer does not answer."""


class Hub:
    """The newest of every message, with its number; `run` keeps them current."""

    def __init__(
        self,
        daemon: Shown,
        *,
        clock: Callable[[], float],
        wall_clock: Callable[[], float],
        own_token: str | None = None,
    ) -> None:
        section = daemon.config.dashboard
        self.daemon, self.clock, self.wall_clock = daemon, clock, wall_clock
        self.section = section
        arena = Bounds(*daemon.config.arena.bounds_m)
        seen = (daemon.calibration, arena, section.picture_width_px, section.jpeg_quality)
        self.view, self.camera_view = TopView(*seen), CameraView(*seen)
        self.gate = AccessGate(section, own_token)
        self.seat = Seat(section.hold_s)
        self.chronicles = Chronicles(daemon.config)
        self.chronicle = self.chronicles.all
        self.viewers: set[Attention] = set()
        self.viewers_ever = 0
        self.pictures_sent = 0
        self.hello = hide_in({**greeting(daemon.config, self.view), "samples": list(COLUMNS)})
        if self.chronicles.configs:
            self.hello["robots"] = hide_in(robots_greeting(self.chronicles.configs))
        self.state_text, self.state_number = "", 0
        self.world, self.heat, self.zones = Made(), Made(), Made()
        self.plan, self.plan_number = b"", 0
        self.saved = SavedPlaces(places_file(daemon.config.recording), self.view.arena)
        self.saved_number = 1
        self._saving, self._zoning = asyncio.Lock(), asyncio.Lock()
        self.pictures: dict[tuple[str, int], tuple[bytes, int]] = {}
        """The newest of each kind and width that is looked at, with its number."""
        self.picture_number = 0
        """Each picture has its own, whatever its kind and width."""
        self.refusal = IT_IS_A_RECORDING if daemon.people is None else None
        """Reason why nothing can be ordered; None where it can."""
        self.epoch = 0
        """Grows where the past becomes another one: pages are greeted again."""
        self.closing = asyncio.Event()
        self.workers = ThreadPoolExecutor(2, thread_name_prefix="dashboard")
        if self.saved.trouble:
            self.note("warn", self.saved.trouble)
        self._state: RunState | None = None
        self._seen_s = -math.inf
        self._told_s = -math.inf
        self._frames: dict[tuple[str, int], Frame] = {}
        self._made_s: dict[str, float] = {}
        self._roadmap: ZonedRoadmap | None = None
        self._closed_by = -1
        self._heated: ZonedRoadmap | None = None
        self._paths: tuple[Path | None, ...] = ()
        self._zoned: int | None = None
        self._others: dict[int, RobotPose] = {}
        self._busy: set[str] = set()
        self._tasks: set[asyncio.Task[None]] = set()

    # The loop.

    async def run(self) -> None:
        """Look repeatedly until the dashboard closes."""
        while not self.closing.is_set():
            try:
                self.look(self.clock())
            except Exception as error:  # noqa: BLE001 - said; STOP must still be served
                self.complain(f"dashboard: {type(error).__name__}: {error}")
            await asyncio.sleep(LOOK_EVERY_S if self.viewers else IDLE_EVERY_S)

    def look(self, now_s: float) -> None:
        """Read the daemon's published state, and wake viewers if there is news."""
        freed = self.seat.tick(now_s)
        if freed is not None:
            self.note("info", freed)
        self._renew_zones()
        state = self.daemon.state
        if state is None:
            return
        news = False
        if state is not self._state:
            self._state, self._seen_s = state, now_s
            self._observe(state)
            news = self._renew_plan(state)
            self._renew_world(state.together.roadmap)
        together = state.together
        self._renew_heat()
        self._renew_pictures(together, now_s)
        if now_s - self._told_s >= STATE_EVERY_S:
            self._told_s = now_s
            self.state_text = self._tell(state, now_s)
            self.state_number += 1
            news = True
        if news:
            self.wake()

    def tell_now(self) -> None:
        """Make the state again: no viewer hears an older one after an answer."""
        if self._state is not None:
            self.state_text = self._tell(self._state, self.clock())
            self.state_number += 1
            self.wake()

    def tell_pages(self, keys: Collection[str], sentence: str) -> None:
        """Send a sentence to the pages that joined with these keys."""
        for viewer in self.viewers:
            if viewer.key in keys:
                viewer.notices.append(sentence)
                viewer.news.set()

    def wake(self) -> None:
        """Make every viewer check for news."""
        for viewer in self.viewers:
            viewer.news.set()

    def admit(self, role: Role) -> Attention | None:
        """Give a viewer a place; None if viewers with the same or more rights hold them all.

        Otherwise the one with the fewest rights, then the oldest, has to leave.
        """
        if len(self.viewers) >= MOST_VIEWERS:
            ranks = list(Role)
            least = min(self.viewers, key=lambda one: (ranks.index(one.role), one.number))
            if not least.role.may_less_than(role):
                return None
            least.displaced.set()
            self.viewers.discard(least)
        self.viewers_ever += 1
        attention = Attention(role, self.viewers_ever)
        self.viewers.add(attention)
        return attention

    def steer(self, _message: Mapping[str, Any]) -> str | None:
        """Refuse to play, pause or seek, as a live run must."""
        return "nothing is replayed here"

    @property
    def loop_age_s(self) -> float:
        """Time since the control loop's last cycle; infinite before the first."""
        return self.clock() - self._seen_s

    def note(self, level: str, text: str) -> None:
        """Add a line to the log."""
        self.chronicle.note(self.wall_clock(), level, text)

    def state_now(self) -> dict[str, Any] | None:
        """Present state as viewers get it; None before the first cycle."""
        return None if self._state is None else self._facts(self._state, self.clock())

    def give(self, request: Mapping[str, Any], who: str) -> dict[str, Any]:
        """Carry out an order of ``who``; return the answer."""
        people = self.daemon.people
        if people is None:
            return {"ok": False, "error": IT_IS_A_RECORDING}
        return give(request, people, who)

    async def preview(
        self, stations: tuple[Station, ...], robot: str | None = None
    ) -> dict[str, Any]:
        """Plan to these stations in a worker thread."""
        people = self.daemon.people
        if people is None:
            return {"ok": False, "reason": IT_IS_A_RECORDING}
        loop = asyncio.get_running_loop()
        try:
            answer = await loop.run_in_executor(self.workers, people.preview, stations, robot)
        except MissionError as error:
            return {"ok": False, "reason": str(error)}
        return preview_facts(answer)

    async def change_zones(self, change: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Make a change that waits for the disk: in another thread, one after another."""
        async with self._zoning:
            return await asyncio.to_thread(change)

    async def change_places(self, message: Mapping[str, Any]) -> str | None:
        """Save, rename or remove a place; return the reason for refusing."""
        async with self._saving:
            work = asyncio.get_running_loop().run_in_executor
            try:
                await work(self.workers, self.saved.change, message)
            except PlaceError as error:
                return str(error)
        self.saved_number += 1
        self.wake()
        return None

    def complain(self, text: str) -> None:
        """Add a warning to the log, once in a row."""
        last = self.chronicle.log.last
        if last is None or last.text != text:
            self.note("warn", text)

    # The messages kept ready.

    def _observe(self, state: RunState) -> None:
        configs = self.chronicles.configs.values() or (self.daemon.config,)
        driven = {one.robot.marker_id for one in configs}
        poses = state.together.poses
        self._others.update((i, poses[i]) for i in poses if i not in driven)
        self.chronicles.see(state, self.daemon.camera_status(), self.wall_clock())

    def _tell(self, state: RunState, now_s: float) -> str:
        return json.dumps(self._facts(state, now_s), allow_nan=False)

    def _facts(self, state: RunState, now_s: float) -> dict[str, Any]:
        message = state_message(
            state.together,
            self.view,
            self.daemon.camera_status(),
            self.seat,
            others=self._others.values(),
            now_s=now_s,
            loop_age_s=now_s - self._seen_s,
            viewers=len(self.viewers),
        )
        if self.chronicles.configs:
            message["robots"] = [
                {
                    "name": name,
                    **robot_facts(one, self.view, now_s),
                    "waits_for": state.waits_for.get(name),
                    "waits": state.waits.get(name),
                }
                for name, one in state.robots.items()
            ]
        facts: dict[str, Any] = hide_in(message)
        return facts

    def _renew_plan(self, state: RunState) -> bool:
        each = {name: one.path for name, one in state.robots.items()}
        paths = tuple(each.values())
        same = len(paths) == len(self._paths) and all(map(operator.is_, paths, self._paths))
        if same and self.plan:
            return False
        if "" in each and each[""] is None and state.only.mission.paused and self.plan:
            return False  # show the driven plan until there is another or the mission ends
        self._paths = paths
        self.plan_number += 1
        number = self.plan_number
        self.plan = plan_message(each[""], number) if "" in each else plans_message(each, number)
        return True

    def _renew_zones(self) -> None:
        zones = self.daemon.zones
        revision = zones.revision  # read before them: what comes between is sent next
        if revision == self._zoned or "zones" in self._busy:
            return
        self._zoned = revision
        self._start("zones", self._make(self.zones, zones_message, zones.zones(), revision))

    def _renew_world(self, walls: Roadmap | None) -> None:
        """Make the roadmap again, with the zones for all robots, where either has changed."""
        zones, known = self.daemon.zones, self._roadmap
        revision = zones.revision  # read before them: what comes between is made next
        same = known is not None and known.walls is walls and revision == self._closed_by
        if walls is None or same or "world" in self._busy:
            return
        self._closed_by, self._roadmap = revision, with_zones(walls, zones_for(zones.zones(), ""))
        self._start("world", self._make(self.world, world_message, self._roadmap))

    def _renew_heat(self) -> None:
        """Make the layer only while somebody has it on."""
        zoned = self._roadmap
        if zoned is None or zoned is self._heated or "heat" in self._busy:
            return
        if any(viewer.wants_heat for viewer in self.viewers):
            self._heated = zoned
            self._start("heat", self._make(self.heat, heat_message, zoned, self.view.window))

    async def _make(self, made: Made, message: Callable[..., bytes], *contents: object) -> None:
        number = made.number + 1
        work = asyncio.get_running_loop().run_in_executor
        made.message = await work(self.workers, lambda: message(*contents, number))
        made.number = number
        self.wake()

    def _renew_pictures(self, state: RobotSnapshot, now_s: float) -> None:
        """Make the newest picture in each size that some viewer could take now.

        Viewers that keep changing their sizes get it neither more often nor twice.
        """
        if (frame := state.frame) is None:
            return
        looking, pause_s = [one for one in self.viewers if one.is_watching], self.picture_pause_s()
        # a viewer that comes to a size that others have left must not get their old picture
        for unseen in self._frames.keys() - {viewer.sees for viewer in looking}:
            if self._frames[unseen] is not frame:
                del self._frames[unseen]
                self.pictures.pop(unseen, None)
        wanted = {viewer.sees for viewer in looking if viewer.wants_picture(now_s, pause_s)}
        for kind in KINDS:
            widths = {w for k, w in wanted if k == kind and self._frames.get((k, w)) is not frame}
            is_due = now_s - self._made_s.get(kind, -math.inf) >= EARLY * pause_s
            if widths and is_due and kind not in self._busy:
                self._made_s[kind] = now_s
                self._frames |= dict.fromkeys(((kind, width) for width in widths), frame)
                self._start(kind, self._make_pictures(kind, widths, frame, state))

    async def _make_pictures(
        self, kind: str, widths: set[int], frame: Frame, state: RobotSnapshot
    ) -> None:
        work = asyncio.get_running_loop().run_in_executor
        self.picture_number += 1
        number = self.picture_number
        age_ms = round((self.clock() - frame.captured_s) * 1e3, 1)
        fields = {"number": number, "age_ms": age_ms}
        if kind == "camera":
            raw = self.camera_view.messages
            made = await work(self.workers, raw, frame, state.poses, state.roadmap, widths, fields)
        else:
            jpegs = await work(self.workers, self.view.jpegs, frame, widths)
            fields["age_ms"] = round((self.clock() - frame.captured_s) * 1e3, 1)
            made = {w: pack("picture", fields, {"jpeg": jpeg}) for w, jpeg in jpegs.items()}
        for width, packed in made.items():
            self.pictures[kind, width] = packed, number
        self.wake()

    def _start(self, name: str, work: Any) -> None:
        """Run one piece of work of a name at a time; log an error."""

        async def guarded() -> None:
            try:
                await work
            except Exception as error:  # noqa: BLE001 - shown to people; the run must continue
                self.note("warn", f"dashboard: {name}: {error}")
            finally:
                self._busy.discard(name)

        self._busy.add(name)
        task = asyncio.get_running_loop().create_task(guarded())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def picture_pause_s(self) -> float:
        """Least time between two pictures for one viewer."""
        watching = sum(viewer.is_watching for viewer in self.viewers)
        return max(1.0 / self.section.picture_rate_hz, watching / PICTURES_S)
