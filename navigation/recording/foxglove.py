"""Foxglove's messages of our objects, so that any viewer of MCAP opens a recording.

The arena is the frame ``arena``: metres, x right, y up, z towards the camera.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final

import cv2
from foxglove.messages import (
    Color,
    CompressedImage,
    Duration,
    LinePrimitive,
    LinePrimitiveLineType,
    Log,
    LogLevel,
    Point3,
    Pose,
    PoseInFrame,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    Timestamp,
    Vector3,
)

from navigation.draw.outlines import object_lines, ring_points
from navigation.draw.shapes import OBSTACLE_EDGE, PATH, Colour, ramp_colour
from navigation.draw.zones import COLOURS as ZONE_COLOURS
from navigation.recording.events import Level
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Scene
from planner.zones.zone import Zone
from vision.camera.camera import Frame
from vision.markers.markers import RobotPose

ARENA_FRAME: Final = "arena"
NANOSECONDS: Final = 1_000_000_000
LINE_PX: Final = 2.0
ROADMAP_COLOUR_STEP: Final = 18

_LEVELS: Final[dict[Level, LogLevel]] = {
    "debug": LogLevel.Debug,
    "info": LogLevel.Info,
    "warning": LogLevel.Warning,
    "error": LogLevel.Error,
}


def timestamp(time_ns: int) -> Timestamp:
    """Timestamp of nanoseconds since 1970."""
    return Timestamp(sec=time_ns // NANOSECONDS, nsec=time_ns % NANOSECONDS)


def image_message(frame: Frame, time_ns: int, form: str, quality: int) -> CompressedImage:
    """Compress a picture; ``form`` is jpeg or png."""
    if form == "jpeg":
        done, data = cv2.imencode(".jpg", frame.image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    else:
        done, data = cv2.imencode(".png", frame.image, [cv2.IMWRITE_PNG_COMPRESSION, 1])
    assert done, "a frame is an 8-bit picture, which OpenCV can encode"
    return CompressedImage(
        timestamp=timestamp(time_ns), frame_id=frame.source, data=data.tobytes(), format=form
    )


def pose_message(pose: RobotPose, time_ns: int) -> PoseInFrame:
    """A robot's pose."""
    half_rad = pose.heading_rad / 2.0
    return PoseInFrame(
        timestamp=timestamp(time_ns),
        frame_id=ARENA_FRAME,
        pose=Pose(
            position=Vector3(x=pose.x, y=pose.y, z=0.0),
            orientation=Quaternion(x=0.0, y=0.0, z=math.sin(half_rad), w=math.cos(half_rad)),
        ),
    )


def log_message(level: Level, sentence: str, source: str, time_ns: int) -> Log:
    """A sentence for people."""
    return Log(timestamp=timestamp(time_ns), level=_LEVELS[level], message=sentence, name=source)


def scene_message(scene: Scene, time_ns: int) -> SceneUpdate:
    """Borders of all obstacles."""
    lines = [line for one in scene.objects for line in object_lines(one, scene.y_down)]
    corners = scene.bounds.corners()
    return _lines_message("scene", [*lines, (*corners, corners[0])], OBSTACLE_EDGE, time_ns)


def roadmap_message(roadmap: Roadmap, time_ns: int) -> SceneUpdate:
    """All edges."""
    lines = [data["polyline"] for _, _, data in roadmap.graph.edges(data=True)]
    return _lines_message("roadmap", lines, ramp_colour(ROADMAP_COLOUR_STEP), time_ns)


def zones_message(zones: Sequence[Zone], time_ns: int) -> SceneUpdate:
    """Outlines of all zones in their colours."""
    drawn = [
        _line((*ring, ring[0]), ZONE_COLOURS[zone.kind])
        for zone in zones
        for part in zone.area.outlines(y_down=False)
        for ring in ring_points(part, y_down=False)
    ]
    return _update("zones", drawn, time_ns)


def path_message(points: FloatArray | None, time_ns: int) -> SceneUpdate:
    """The planned path, if any."""
    return _lines_message("plan", [] if points is None else [points], PATH, time_ns)


def _lines_message(
    name: str, lines: Iterable[Iterable[Iterable[float]]], colour: Colour, time_ns: int
) -> SceneUpdate:
    return _update(name, [_line(line, colour) for line in lines], time_ns)


def _line(line: Iterable[Iterable[float]], colour: Colour) -> LinePrimitive:
    red, green, blue = (part / 255.0 for part in colour)
    return LinePrimitive(
        type=LinePrimitiveLineType.LineStrip,
        thickness=LINE_PX,
        scale_invariant=True,
        points=[Point3(x=float(x), y=float(y), z=0.0) for x, y in line],
        color=Color(r=red, g=green, b=blue, a=1.0),
    )


def _update(name: str, lines: list[LinePrimitive], time_ns: int) -> SceneUpdate:
    entity = SceneEntity(
        timestamp=timestamp(time_ns),
        frame_id=ARENA_FRAME,
        id=name,
        lifetime=Duration(sec=0),
        lines=lines,
    )
    return SceneUpdate(entities=[entity])
