"""Values of a first configuration: an arena, a robot, a mission, in the robot's size.

The demo's arena fits our own small robot; for another one it grows or shrinks with the body.
Metres, degrees.
"""

from __future__ import annotations

import re
from typing import Any, Final

from navigation.config.known_robots import CLEARWAY, KNOWN_ROBOTS

OWN_RADIUS_M: Final = 0.09
OWN_MARKER_M: Final = 0.09
SAFE_SHARE: Final = 0.8
"""Share of the highest speed that its maker states."""
ROOMY: Final = 1.05
"""Grows the disc around a body whose marker does not sit exactly in the middle."""
ARENA_TEXT: Final = """#@ clearway.scene/1
#@ units m
# a triangle, a bucket, an L and a D whose first edge is an arc; clockwise, x right, y up
L 3 (0.60,0.70) (0.72,0.34) (0.44,0.42)
C (0.50,1.22) 0.14
L 6 (1.60,1.40) (1.70,1.40) (1.70,1.00) (2.02,1.00) (2.02,0.90) (1.60,0.90)
L 4 (1.15,0.60) (1.15,0.30) (1.05,0.30) (1.05,0.60)
#@ arc 1 1.15 0.45 0.15 cw
L 4 (0.95,1.40) (1.25,1.30) (1.20,1.15) (0.90,1.25)
L 3 (1.85,0.62) (2.05,0.40) (1.75,0.38)
"""
_OWN: Final = {
    "marker_id": 7,
    "marker_size_m": OWN_MARKER_M,
    "marker_height_m": 0.12,
    "radius_m": OWN_RADIUS_M,
}
PORTS: Final = {"turtlebot3": "/dev/ttyACM0", "epuck2": "/dev/ttyACM0"}


def demo_values(robot: str = CLEARWAY) -> dict[str, Any]:
    """A simulated arena with the robot in it; loads and runs as it is."""
    grown = _grown(robot)
    values: dict[str, Any] = {
        "arena": _arena(grown),
        "camera": {"source": "simulated"},
        "robot": robot_values(robot),
        "mission": {
            "stations": [
                {"x_m": _size(1.40 * grown), "y_m": _size(0.90 * grown), "dwell_s": 0.5},
                {"x_m": _size(2.20 * grown), "y_m": _size(1.60 * grown), "heading_deg": 90},
            ]
        },
        "simulation": {
            "arena_text": _scaled(ARENA_TEXT, grown),
            "start": {"x_m": _size(0.2 * grown), "y_m": _size(0.2 * grown), "heading_deg": 45},
        },
    }
    if robot != CLEARWAY:
        lens = [_size(1.155 * grown), _size(0.975 * grown), _size(2.5 * grown)]
        values["simulation"]["camera"] = {"position_m": lens}
        values["planning"] = planning_values(robot)
        values["serial"] = {"baud": KNOWN_ROBOTS[robot].baud}
    return values


def real_values(robot: str = CLEARWAY) -> dict[str, Any]:
    """A real camera and a real robot, to be measured and set."""
    values: dict[str, Any] = {
        "arena": _arena(_grown(robot)),
        "camera": {"source": 0, "calibration": "calibration.yaml"},
        "robot": robot_values(robot),
        "serial": {"port": PORTS.get(robot, "/dev/ttyUSB0")},
    }
    if robot != CLEARWAY:
        values["planning"] = planning_values(robot)
        values["serial"]["baud"] = KNOWN_ROBOTS[robot].baud
    return values


def robot_values(robot: str) -> dict[str, Any]:
    """The section `robot`: the true dimensions, and limits with a reserve."""
    if robot == CLEARWAY:
        return dict(_OWN)
    known = KNOWN_ROBOTS[robot]
    return {
        "driver": robot,
        **({"model": known.models[0]} if known.models else {}),
        "marker_id": 7,
        "marker_size_m": known.marker_m,
        "marker_height_m": known.height_m,
        "radius_m": _size(known.radius_m * ROOMY),
        "speed_m_s": _size(known.speed_m_s * SAFE_SHARE),
        "acceleration_m_s2": known.acceleration_m_s2,
        "lateral_acceleration_m_s2": known.acceleration_m_s2,
        "angular_rate_rad_s": _size(known.turn_rad_s * SAFE_SHARE / 2),
        "angular_acceleration_rad_s2": known.turn_acceleration_rad_s2,
        "track_m": known.track_m,
    }


def planning_values(robot: str) -> dict[str, Any]:
    """The section `planning` for a body of that size."""
    grown = _grown(robot)
    return {
        "margin_m": _size(0.015 * grown),
        "waypoint_spacing_m": _size(0.05 * grown),
        "slow_clearance_m": _size(0.20 * grown),
        "slow_speed_m_s": _size(KNOWN_ROBOTS[robot].speed_m_s * SAFE_SHARE / 2),
    }


def _grown(robot: str) -> float:
    """Size relative to our own robot."""
    return 1.0 if robot == CLEARWAY else KNOWN_ROBOTS[robot].radius_m * ROOMY / OWN_RADIUS_M


def _arena(grown: float) -> dict[str, Any]:
    return {"bounds_m": [0.0, 0.0, _size(2.4 * grown), _size(1.8 * grown)]}


def _scaled(text: str, grown: float) -> str:
    """A scene's text with the numbers that have a decimal point scaled."""
    if grown == 1.0:
        return text
    return re.sub(r"\d+\.\d+", lambda number: f"{float(number[0]) * grown:.4f}", text)


def _size(value: float) -> float:
    return round(value, 3)
