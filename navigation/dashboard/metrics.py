"""/metrics: the running program's numbers for Prometheus, gathered only when asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from navigation.dashboard.hub import Hub
from navigation.mission.mission import State


class DaemonCollector(Collector):
    """Reads the hub at the time of the scrape; nothing is counted twice."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub

    def collect(self) -> Iterator[Any]:
        """Every metric; those of the daemon from its first cycle on."""
        hub = self._hub
        yield _gauge("dashboard_viewers", "Pages that are open.", len(hub.viewers))
        yield _counter("dashboard_pictures", "Pictures sent to pages.", hub.pictures_sent)
        refused = CounterMetricFamily(
            "clearway_dashboard_refused", "What the dashboard turned away.", labels=["kind"]
        )
        for kind, count in sorted(hub.gate.refused.items()):
            refused.add_metric([kind], count)
        yield refused
        state = hub.state_now()
        if state is not None:
            yield from _daemon_metrics(state)


def metrics_text(hub: Hub) -> bytes:
    """The text that Prometheus reads."""
    registry = CollectorRegistry(auto_describe=False)
    registry.register(DaemonCollector(hub))
    return generate_latest(registry)


def _daemon_metrics(state: dict[str, Any]) -> Iterator[Any]:
    mission, camera, link = state["mission"], state["camera"], state["link"]
    states = GaugeMetricFamily(
        "clearway_mission_state", "1 for the mission's present state.", labels=["state"]
    )
    for one in State:
        states.add_metric([one.value], float(one.value == mission["state"]))
    yield states
    yield _gauge("mission_stations", "Stations of the mission.", len(mission["stations"]))
    yield _gauge("mission_stations_visited", "Stations visited so far.", mission["visited"])
    yield _gauge("run_seconds", "Time since the run began.", state["time_s"])
    yield _gauge("loop_age_seconds", "Since the last control cycle.", _s(state["loop_ms"]))
    yield _gauge("to_go_metres", "Left of the plan.", state["to_go_m"])
    yield _gauge("clearance_metres", "From the robot to the nearest border.", state["clearance_m"])
    pose = state["pose"]
    yield _gauge("pose_age_seconds", "Age of the robot's pose.", pose and _s(pose["age_ms"]))
    yield _gauge("camera_up", "1 while the camera gives pictures.", camera["state"] == "running")
    yield _gauge("camera_rate_hertz", "Pictures a second.", camera["rate_hz"])
    yield _counter("camera_frames", "Pictures captured.", camera["captured"])
    yield _counter("camera_frames_dropped", "Pictures that were not used.", camera["dropped"])
    yield _counter("camera_reopened", "Times the camera was opened again.", camera["reopened"])
    yield _gauge("link_up", "1 while the link to the robot is up.", link["reason"] is None)
    yield _gauge("link_round_trip_seconds", "Smoothed.", _s(link["round_trip_ms"]))
    yield _counter("link_frames_sent", "Frames sent to the robot.", link["sent_frames"])
    yield _counter("link_frames_received", "Frames from the robot.", link["received_frames"])
    yield _counter("link_retransmits", "Frames sent again.", link["retransmits"])
    yield _counter("link_crc_errors", "Frames that arrived damaged.", link["crc_errors"])
    yield _counter("link_lost", "Times the link was lost.", link["links_lost"])
    yield _counter(
        "link_taken_back", "Times another host had the robot and fell silent.", link["taken_back"]
    )
    yield _counter(
        "link_stray_hellos", "Answers of the robot to a greeting not ours.", link["stray_hellos"]
    )
    yield _counter(
        "link_clock_jumps", "Jumps of the robot's clock or the host's.", link["clock_jumps"]
    )
    yield _counter("link_stale", "Permits and poses too old to be sent.", link["stale"])
    yield _gauge("robot_estopped", "1 while the robot is emergency-stopped.", link["estopped"])
    for name, value in state["times"].items():
        stage = name.removesuffix("_ms")
        yield _gauge(f"{stage}_seconds", f"How long the stage '{stage}' took last.", _s(value))


def _gauge(name: str, text: str, value: float | bool | None) -> GaugeMetricFamily:
    family = GaugeMetricFamily(f"clearway_{name}", text)
    if value is not None:
        family.add_metric([], float(value))
    return family


def _counter(name: str, text: str, value: float) -> CounterMetricFamily:
    return CounterMetricFamily(f"clearway_{name}", text, value=float(value))


def _s(milliseconds: float | None) -> float | None:
    return None if milliseconds is None else milliseconds / 1e3
