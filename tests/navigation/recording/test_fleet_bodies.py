"""A request to the planner of several robots through a recording's JSON and back."""

from __future__ import annotations

import json
import math

import numpy as np

from navigation.fleet.request import Driving, FleetRequest, Gate, Promise, Taken, Traveller
from navigation.mission.mission import Station
from navigation.recording.events import PlanAsked
from navigation.recording.json_bodies import FLEET_REQUESTS, request_message, request_of
from planner.path import Limits, Path

LIMITS = Limits(0.3, 0.5, 0.4, 2.0, 6.0, 5.0, 0.05, 0.002, 0.2, 0.12)


def driving() -> Driving:
    points = np.array([[0.1, 0.2], [1.0 / 3.0, 0.2], [0.7, math.pi / 10.0]])
    path = Path(points, np.ones(3), 1.0, 0.2, (0.1, 0.2), 0.09, (0, 2), (None, None))
    gates = (Gate(1, "b", 4),)
    promise = Promise("a", Station(0.7, 0.3), points, (), gates, path, None, 0.09, 0.015)
    return Driving(promise, 1, 2, LIMITS)


def test_a_request_while_others_drive_comes_back_to_the_bit() -> None:
    asking = Traveller("c", (0.1, 0.9, 0.5), Station(2.0, 1.0, 0.1), 0.09, LIMITS)
    idle = Traveller("d", (1.1, 0.9, 0.5), Station(1.1, 0.9), 0.09, LIMITS)
    taken = Taken("e", 0.5, 0.5, 0.1)
    asked = FleetRequest(7, 3, (asking,), (taken,), (driving(),), (idle,))
    topic, body = request_message(PlanAsked(1.5, asked))
    assert topic == FLEET_REQUESTS
    back = request_of(topic, json.loads(json.dumps(body)))
    assert (back.id, back.scene_revision) == (7, 3)
    assert (back.travellers, back.taken, back.idle) == ((asking,), (taken,), (idle,))
    (one,), same = back.driving, driving()
    assert (one.executed, one.sent, one.limits) == (1, 2, LIMITS)
    assert np.array_equal(one.promise.points, same.promise.points)
    for name in ("name", "station", "gates", "radius_m", "margin_m"):
        assert getattr(one.promise, name) == getattr(same.promise, name)
