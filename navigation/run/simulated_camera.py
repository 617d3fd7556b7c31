"""The simulated camera above a changing arena, itself subject to knocks. Metres, seconds."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from navigation.config import Config
from navigation.config.simulation import SimulatedKnockSection
from navigation.simulator.arena import SimulatedArena
from navigation.simulator.happenings import ScriptedTrack
from navigation.simulator.picture.camera import Driven, PoseAt, make_camera
from navigation.simulator.picture.knocked_camera import Knock, KnockedCamera
from navigation.simulator.picture.timed_camera import TimedCamera


def camera_over(
    config: Config,
    arenas: Sequence[tuple[float, SimulatedArena]],
    tracks: Mapping[int, ScriptedTrack],
    driven: Driven,
    clock: Callable[[], float],
    began_s: float,
    wait: Callable[[float], None] = time.sleep,
    make: Callable[..., TimedCamera[Any]] = make_camera,
) -> TimedCamera[Any] | KnockedCamera:
    """Make the camera over ``arenas``, each valid from its time after ``began_s`` on.

    ``tracks`` belong to robots driven elsewhere.
    """

    def follow(track: ScriptedTrack) -> PoseAt:
        return lambda at_s: track.pose(at_s - began_s)

    now_s = clock() - began_s
    past = [arena for from_s, arena in arenas if from_s <= now_s]

    def hanging(knock: SimulatedKnockSection | None) -> TimedCamera[Any]:
        return make(
            config,
            past[-1],
            driven,
            clock,
            wait,
            [
                follow(tracks[one.marker_id]) if one.marker_id in tracks else None
                for one in config.other_robots
            ],
            [(began_s + from_s, arena.scene) for from_s, arena in arenas if from_s > now_s],
            knock,
        )

    knocks = () if config.simulation is None else config.simulation.camera.knocks
    if not knocks:
        return hanging(None)
    return KnockedCamera(
        hanging(None),
        [
            Knock(
                began_s + one.from_s,
                math.inf if one.until_s is None else began_s + one.until_s,
                hanging(one),
            )
            for one in sorted(knocks, key=lambda one: one.from_s)
        ],
        clock,
    )
