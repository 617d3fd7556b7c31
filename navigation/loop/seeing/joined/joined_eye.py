"""The eye of several cameras: frames of each in, one set of poses and one scene out.

Rules
- Each camera has its own marker tracker and its own watch for changes. Its background is laid onto
  the floor plan only after a change; the plan's picture is extracted like a single camera's.
- A camera is lost (unplugged, frozen or hung) if it gives no new picture for ``stale_s`` while the
  others do. What only it saw is an obstacle at once, like all unseen ground; a robot there holds.
  Its ground is open again from its first picture in which the robots' places are known.
- A camera that was knocked holds every robot, because what it looks at is unknown. While it is
  lost, nothing relies on its word.
- There is no scene until every camera has shown the arena, or was lost after ``START_S``.

Metres and radians in the arena, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np

import vision
from navigation.loop.seeing.eye import EyeSettings, Glimpse, Poses, doubles_of
from planner.scene import FloatArray
from vision.camera.camera import Frame, Image
from vision.joined.floor_plan import CameraPart, FloorPlan, Rectangle
from vision.joined.outline_agreement import edge_points_m, outlines_apart_m
from vision.joined.pose_fusion import PoseFusion, carried
from vision.markers.marker_search import grey_of
from vision.markers.markers import MarkerTracker, RobotPose, body_discs_px
from vision.records.unseen import Unseen, unseen_ground, with_unseen
from vision.watch.camera_place import NOTHING_KNOWN, CameraPlace, PlaceReport, said_together
from vision.watch.change import Change, SceneWatcher
from vision.watch.refit import KnownScene

START_S: Final = 3.0
"""Longest wait for a camera's first picture after another one's."""
MISSED_FRAMES: Final = 3
"""Pictures of others after which a camera may be lost: a late loop has old pictures of all."""
WITHIN_M: Final = 1e-3


@dataclass(frozen=True, slots=True)
class JoinedSettings:
    """Requirements of several cameras beside the eye's settings.

    ``apart_m`` is the most that their outlines may differ.
    """

    names: tuple[str, ...]
    stale_s: float
    apart_m: float


@dataclass(slots=True)
class _View:
    tracker: MarkerTracker
    watcher: SceneWatcher
    background: Image | None = None
    """Arena without robots; None while the camera is lost or only just back."""
    last_s: float = -math.inf
    missed: int = 0
    """Frames of the other cameras since its last."""
    edges: FloatArray | None = None
    place: CameraPlace | None = None
    """Watches whether it was knocked."""
    placed: PlaceReport = NOTHING_KNOWN


class JoinedEye:
    """Views of each camera, fused poses, and the whole arena's picture."""

    def __init__(
        self,
        plan: FloorPlan,
        trackers: Sequence[MarkerTracker],
        fusion: PoseFusion,
        settings: EyeSettings,
        joined: JoinedSettings,
        places: Sequence[CameraPlace] = (),
    ) -> None:
        self.plan, self.settings = plan, settings
        self._joined = joined
        watched: Sequence[CameraPlace | None] = places or [None] * len(trackers)
        self._views = [
            _View(tracker, self._new_watcher(i), place=place)
            for i, (tracker, place) in enumerate(zip(trackers, watched, strict=True))
        ]
        self._index = {name: i for i, name in enumerate(joined.names)}
        self._fusion = fusion
        self._last_seen: dict[int, RobotPose] = {}
        self._known: KnownScene | None = None
        self._first_s: float | None = None
        self._lost: frozenset[int] = frozenset()
        self._live: tuple[bool, ...] = (False,) * len(trackers)
        self._owners = plan.owners(self._live)
        self._unknown = plan.unknown(self._live)
        self._unseen = Unseen()
        self._gains: FloatArray = np.ones(len(trackers))
        self._canvas = np.zeros(self._owners.shape, np.uint8)
        self._parts: list[CameraPart | None] = [None] * len(trackers)
        self._apart: dict[tuple[int, int], float] = {}
        self._count = 0

    def _new_watcher(self, _index: int) -> SceneWatcher:
        return SceneWatcher()

    def look(self, frame: Frame, tell: Callable[[Poses], None] = lambda _: None) -> Glimpse:
        """Take one camera's frame; ``tell`` gets its poses before anything else is looked at.

        The frame's ``source`` is the camera's name. The glimpse has the poses of all cameras and
        the picture of the whole arena.
        """
        frame = replace(frame, image=grey_of(frame.image))
        index = self._index[frame.source]
        self._note_arrival(index, frame.captured_s)
        view = self._views[index]
        fused = self._fusion.take(index, view.tracker.update(frame))
        fresh = {pose.id: self._on_plan(index, pose) for pose in fused}
        tell(fresh)
        self._last_seen.update(fresh)
        now = self._present(frame.captured_s)
        discs = self._body_discs(index, frame.captured_s, now)
        if view.place is not None:
            view.placed = view.place.look(
                frame.image,
                discs if self._last_seen else None,
                frame.captured_s,
                may_learn=view.background is not None,
            )
        change = self._watch(index, frame, now, discs)
        scene = None
        if self._is_ready(frame.captured_s) and self._is_new(change):
            self._known = self._brought_up_to_date(index, change)
            scene = self._known.scene
        part = self._parts[index]
        if part is not None:
            self.plan.draw(self._canvas, index, frame.image, part, float(self._gains[index]))
        doubles = self._doubles()
        return Glimpse(
            frame.captured_s,
            now,
            scene,
            change,
            doubles,
            said_together(one.placed for one in self._views),
            picture=self._picture(frame.captured_s),
            hold=self._hold(),
            troubles=self._troubles(),
        )

    def _note_arrival(self, index: int, captured_s: float) -> None:
        self._first_s = captured_s if self._first_s is None else self._first_s
        for other, view in enumerate(self._views):
            view.missed = 0 if other == index else view.missed + 1
        view = self._views[index]
        view.last_s = max(view.last_s, captured_s)
        newest_s = max(one.last_s for one in self._views)
        self._lost = frozenset(
            i
            for i, one in enumerate(self._views)
            if one.missed >= MISSED_FRAMES and newest_s - one.last_s > self._joined.stale_s
        )
        for i in self._lost:
            one = self._views[i]
            if one.background is not None:
                one.background, one.watcher, one.edges = None, self._new_watcher(i), None
                one.placed = NOTHING_KNOWN
                self._fusion.forget(i)
                self._apart = {pair: v for pair, v in self._apart.items() if i not in pair}

    def _is_ready(self, now_s: float) -> bool:
        """True if unseen ground is not merely ground not seen yet."""
        started = self._first_s is not None and now_s - self._first_s > START_S
        waits = any(
            one.background is None and not (started and i in self._lost)
            for i, one in enumerate(self._views)
        )
        if self._known is not None:
            return any(one.background is not None for one in self._views)
        return not waits

    def _is_new(self, change: Change | None) -> bool:
        return change is not None or self._known is None or self._live_now() != self._live

    def _live_now(self) -> tuple[bool, ...]:
        return tuple(one.background is not None for one in self._views)

    def _present(self, now_s: float) -> dict[int, RobotPose]:
        stale_s = self._joined.stale_s
        return {i: p for i, p in self._last_seen.items() if abs(now_s - p.captured_s) <= stale_s}

    def _watch(self, index: int, frame: Frame, now: Poses, discs: FloatArray) -> Change | None:
        driven = self.settings.driven_ids
        if not all(i in self._last_seen for i in driven) or not any(i in now for i in driven):
            return None
        view = self._views[index]
        change = view.watcher.update(frame.image, discs)
        if change is not None:
            view.background = view.watcher.background
            view.edges = None
        return change

    def _body_discs(self, index: int, now_s: float, now: Poses) -> FloatArray:
        """Discs of all robots' bodies in this camera's picture."""
        calibration = self.plan.cameras[index]
        discs = [np.empty((0, 3))]
        for robot_id, pose in self._last_seen.items():
            body = self.settings.bodies[robot_id]
            here = carried(pose, now_s)
            if not self._may_show(index, here):
                continue
            reach_m = 0.0 if robot_id in now else self.settings.reach_m
            discs.append(
                body_discs_px(here, body.radius_m + reach_m, calibration, body.marker_height_m)
            )
        return np.concatenate(discs)

    def _may_show(self, index: int, pose: RobotPose) -> bool:
        """True if the camera's model holds at a place: far outside, it maps elsewhere."""
        calibration = self.plan.cameras[index]
        place = np.array([(pose.x, pose.y)])
        with np.errstate(all="ignore"):
            pixel = calibration.image_from_arena(place)
            far = 2.0 * max(calibration.size)
            if not (np.isfinite(pixel).all() and (np.abs(pixel) < far).all()):
                return False
            back = calibration.arena_from_image(pixel)
        return bool(np.hypot(*(back - place)[0]) < WITHIN_M)

    def _brought_up_to_date(self, index: int, change: Change | None) -> KnownScene:
        """Present scene; only changes are fitted again, if that can be trusted."""
        is_new = self._note_live()
        if is_new:
            self._parts = [CameraPart.of(self._owners, i) for i in range(len(self._live))]
        pictures = [one.background for one in self._views]
        whole = is_new or self._known is None or change is None or change.first or change.relit
        if whole:
            self._gains = self.plan.gains(pictures)
            self._canvas = self.plan.picture(pictures, self._owners, self._gains)
        self._compare_outlines()
        background = self.plan.picture(pictures, self._owners, self._gains)
        if not whole and self._known is not None and change is not None:
            known = self._known.refitted(background, self._on_the_plan(index, change))
            if known is not None:
                return known
        scene = vision.extract(
            background,
            **dict(self.settings.vision),
            calibration=self.plan.calibration,
            bounds=self.settings.bounds_m,
        )
        seen = with_unseen(scene, self._unseen)
        return KnownScene.of(seen, self.plan.calibration, self._unseen)

    def _note_live(self) -> bool:
        """Update the live cameras and the unseen ground; True if they changed."""
        live = self._live_now()
        if live == self._live:
            return False
        self._live = live
        self._owners, self._unknown = self.plan.owners(live), self.plan.unknown(live)
        self._unseen = self._not_seen()
        return True

    def _not_seen(self) -> Unseen:
        if self._unknown is None:
            return Unseen()
        ground = unseen_ground(
            self._unknown, self.plan.calibration, self.settings.bounds_m, vision.extract
        )
        share = 100.0 * float(self._unknown.mean())
        return Unseen(
            ground,
            f"{share:.0f} % of the arena is seen by no camera and an obstacle{self._who_is_lost()}",
        )

    def _on_the_plan(self, index: int, change: Change) -> list[Rectangle]:
        found = [self.plan.rectangle(index, one) for one in change.rectangles]
        return [one for one in found if one is not None]

    def _compare_outlines(self) -> None:
        fresh = set()
        for index, view in enumerate(self._views):
            if view.background is None or view.edges is not None:
                continue
            fresh.add(index)
            view.edges = edge_points_m(
                view.background, self.plan, index, **dict(self.settings.vision)
            )
        for one, other in combinations(range(len(self._views)), 2):
            a, b = self._views[one].edges, self._views[other].edges
            if a is None or b is None or not {one, other} & fresh:
                continue
            apart_m = outlines_apart_m(self.plan, one, other, a, b)
            if apart_m is not None:
                self._apart[one, other] = apart_m

    def _picture(self, captured_s: float) -> Frame:
        self._count += 1
        canvas = self._canvas.copy()
        if self._unknown is not None:
            canvas[(self._owners < 0) & (self._unknown >= 0.5)] = 128
        return Frame(canvas, captured_s, self._count - 1, " + ".join(self._joined.names))

    def _on_plan(self, index: int, pose: RobotPose) -> RobotPose:
        floor = self.plan.cameras[index].arena_from_image(pose.corners_px)
        corners = self.plan.calibration.image_from_arena(floor)
        corners.setflags(write=False)
        return replace(pose, corners_px=corners)

    def _doubles(self) -> dict[int, str]:
        found: dict[int, str] = {}
        for view in self._views:
            found |= doubles_of(view.tracker, self.settings.driven_ids)
        said = self._fusion.contradictions
        return found | {i: said[i] for i in self.settings.driven_ids if i in said}

    def _hold(self) -> str | None:
        """Reason why no robot may drive: one is on unseen ground, or cameras disagree."""
        names = self._joined.names
        for (one, other), apart_m in self._apart.items():
            if apart_m > self._joined.apart_m:
                return (
                    f"cameras {names[one]} and {names[other]} see the same outlines "
                    f"{1000.0 * apart_m:.0f} mm apart, the limit is "
                    f"{1000.0 * self._joined.apart_m:.0f}: calibrate both to one floor"
                )
        unknown = self._unknown if self._known is not None else None
        for robot_id in self.settings.driven_ids if unknown is not None else ():
            pose = self._last_seen.get(robot_id)
            body = self.settings.bodies[robot_id]
            assert unknown is not None
            if pose is not None and self.plan.is_unknown(unknown, pose.x, pose.y, body.radius_m):
                return (
                    f"the robot is at ({pose.x:.2f}, {pose.y:.2f}) m, where no camera sees the "
                    f"floor{self._who_is_lost()}"
                )
        return None

    def _who_is_lost(self) -> str:
        lost = [self._joined.names[i] for i in sorted(self._lost)]
        return f": {' and '.join(lost)} {'is' if len(lost) == 1 else 'are'} lost" if lost else ""

    def _troubles(self) -> Mapping[str, str]:
        said = {}
        for index, name in enumerate(self._joined.names):
            sentence = ""
            if index in self._lost:
                sentence = f"camera {name} is lost: what only it sees is closed to the robot"
            elif self._known is not None and self._views[index].background is None:
                sentence = (
                    f"camera {name} is back: what only it sees stays closed to the robot until "
                    "the robot is seen again"
                )
            said[f"camera {name}"] = sentence
        return said
