"""/metrics of one robot and of several: the same numbers, labelled with names where there are."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any, cast

from navigation.dashboard.hub import Hub
from navigation.dashboard.metrics import metrics_text

LINK = {
    "reason": None, "round_trip_ms": 2.5, "sent_frames": 10, "received_frames": 9,
    "retransmits": 1, "crc_errors": 2, "links_lost": 0, "taken_back": 0, "stray_hellos": 0,
    "clock_jumps": 0, "stale": 3, "estopped": False,
}  # fmt: skip
ROBOT: dict[str, Any] = {
    "mission": {"state": "driving", "stations": [{}, {}], "visited": 1},
    "pose": {"age_ms": 40.0},
    "to_go_m": 1.5,
    "clearance_m": 0.25,
    "link": LINK,
}
RUN: dict[str, Any] = {
    "time_s": 12.0, "loop_ms": 20.0, "times": {"look_ms": 8.0},
    "camera": {
        "state": "running", "rate_hz": 30.0, "captured": 300, "dropped": 1, "reopened": 0,
    },
}  # fmt: skip


def samples(state: dict[str, Any]) -> dict[str, float]:
    """By name and labels: the value of every sample of the daemon."""
    gate = SimpleNamespace(refused={})
    hub = SimpleNamespace(viewers=[], pictures_sent=0, gate=gate, state_now=lambda: state)
    text = metrics_text(cast("Hub", hub)).decode()
    rows = re.findall(r"^(clearway_\S+) (\S+)$", text, re.MULTILINE)
    return {name: float(value) for name, value in rows}


def robot(name: str, **changes: Any) -> dict[str, Any]:
    return {**ROBOT, "name": name, "waits": None, **changes}


def test_one_robot_has_no_label() -> None:
    told = samples({**RUN, **ROBOT})
    assert told["clearway_to_go_metres"] == 1.5
    assert told["clearway_link_crc_errors_total"] == 2.0
    assert told['clearway_mission_state{state="driving"}'] == 1.0
    assert not any("robot=" in name for name in told)


def test_each_of_several_robots_has_the_values_of_one_alone_under_its_name() -> None:
    alone = samples({**RUN, **ROBOT})
    told = samples({**RUN, **ROBOT, "robots": [robot("ada"), robot("bob")]})
    for name, value in samples({**RUN, **ROBOT}).items():
        if name in told:
            assert told[name] == value, "what there is once is told once"
            continue
        bare, _, labels = name.partition("{")
        for one in ("ada", "bob"):
            inside = ",".join(filter(None, (f'robot="{one}"', labels.rstrip("}"))))
            assert told[f"{bare}{{{inside}}}"] == value
    once = {name for name in told if "robot=" not in name}
    assert once < alone.keys()
    assert "clearway_camera_frames_total" in once
    assert "clearway_to_go_metres" not in once


def test_names_tell_robots_apart_that_differ() -> None:
    stopped = {**LINK, "estopped": True, "crc_errors": 7, "reason": "the robot is silent"}
    bob = robot("bob", link=stopped, to_go_m=None, pose=None, waits="waits for ada")
    told = samples({**RUN, **ROBOT, "robots": [robot("ada"), bob]})
    assert told['clearway_robot_estopped{robot="ada"}'] == 0.0
    assert told['clearway_robot_estopped{robot="bob"}'] == 1.0
    assert told['clearway_link_up{robot="bob"}'] == 0.0
    assert told['clearway_link_crc_errors_total{robot="bob"}'] == 7.0
    assert told['clearway_robot_waits{robot="bob"}'] == 1.0
    assert told['clearway_robot_waits{robot="ada"}'] == 0.0
    assert 'clearway_to_go_metres{robot="bob"}' not in told
    assert told['clearway_to_go_metres{robot="ada"}'] == 1.5
