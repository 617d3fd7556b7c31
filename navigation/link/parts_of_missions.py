"""Missions sent in parts: what the host's end may send, and when more."""

from __future__ import annotations

from firmware_protocol.host.connection import HostConnection
from firmware_protocol.wire.mission import Mission


def give_mission(
    host: HostConnection, mission: Mission, now_s: float, start: bool, released: int | None
) -> None:
    """Replace the robot's mission; at most ``released`` waypoints are sent yet."""
    host.upload(mission, now_s, start)
    if released is not None and host.upload_state is not None:
        host.upload_state.hold_back(released)


def release_mission(host: HostConnection, mission_id: int, count: int) -> None:
    """Release the first ``count`` waypoints, if the host still has this mission."""
    upload = host.upload_state
    if upload is not None and upload.mission.id == mission_id:
        upload.release(count)
