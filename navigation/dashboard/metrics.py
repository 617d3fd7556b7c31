"""/metrics: the running program's numbers for Prometheus.

With several robots a value has a label: ``robot="ada"``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, Final, TypeAlias

from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from navigation.dashboard.hub import Hub
from navigation.mission.mission import State


class DaemonCollector(Collector):
    """Reads the hub at the time of the scrape."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub

    def collect(self) -> Iterator[Any]:
        """Yield every metric; the daemon's from its first cycle on."""
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
    """Text that Prometheus reads."""
    registry = CollectorRegistry(auto_describe=False)
    registry.register(DaemonCollector(hub))
    return generate_latest(registry)


def _daemon_metrics(state: dict[str, Any]) -> Iterator[Any]:
    camera = state["camera"]
    yield _gauge("run_seconds", "Time since the run began.", state["time_s"])
    yield _gauge("loop_age_seconds", "Since the last control cycle.", _s(state["loop_ms"]))
    yield _gauge("camera_up", "1 while the camera gives pictures.", camera["state"] == "running")
    yield _gauge("camera_rate_hertz", "Pictures a second.", camera["rate_hz"])
    yield _counter("camera_frames", "Pictures captured.", camera["captured"])
    yield _counter("camera_frames_dropped", "Pictures that were not used.", camera["dropped"])
    yield _counter("camera_reopened", "Times the camera was opened again.", camera["reopened"])
    yield from _robot_metrics(state)
    for name, value in state["times"].items():
        stage = name.removesuffix("_ms")
        yield _gauge(f"{stage}_seconds", f"How long the stage '{stage}' took last.", _s(value))


def _robot_metrics(state: dict[str, Any]) -> Iterator[Any]:
    named = state.get("robots")
    robots = {one["name"]: one for one in named} if named else {None: state}
    labels = ["robot"] if named else []
    states = GaugeMetricFamily(
        "clearway_mission_state", "1 for the mission's present state.", labels=[*labels, "state"]
    )
    for name, robot in robots.items():
        for one in State:
            value = float(one.value == robot["mission"]["state"])
            states.add_metric([*_label(name), one.value], value)
    yield states

    for metric, text, read in _ROBOT_GAUGES:
        yield _gauge_of(metric, text, {name: read(one) for name, one in robots.items()})
    if named:
        waits = {name: one["waits"] is not None for name, one in robots.items()}
        yield _gauge_of("robot_waits", "1 while the robot waits for others.", waits)
    for metric, key, text in _LINK_COUNTERS:
        counts = {name: one["link"][key] for name, one in robots.items()}
        yield _counter_of(f"link_{metric}", text, counts)


_Values: TypeAlias = Mapping[str | None, float | bool | None]
"""By robot's name; None for a single robot, and for what there is once."""
_Read: TypeAlias = Callable[[dict[str, Any]], float | bool | None]
_ROBOT_GAUGES: Final[tuple[tuple[str, str, _Read], ...]] = (
    ("mission_stations", "Stations of the mission.", lambda r: len(r["mission"]["stations"])),
    ("mission_stations_visited", "Stations visited so far.", lambda r: r["mission"]["visited"]),
    ("to_go_metres", "Left of the plan.", lambda r: r["to_go_m"]),
    ("clearance_metres", "From the robot to the nearest border.", lambda r: r["clearance_m"]),
    (
        "pose_age_seconds",
        "Age of the robot's pose.",
        lambda r: None if r["pose"] is None else _s(r["pose"]["age_ms"]),
    ),
    ("link_up", "1 while the link to the robot is up.", lambda r: r["link"]["reason"] is None),
    ("link_round_trip_seconds", "Smoothed.", lambda r: _s(r["link"]["round_trip_ms"])),
    ("robot_estopped", "1 while the robot is emergency-stopped.", lambda r: r["link"]["estopped"]),
)
_LINK_COUNTERS: Final = (
    ("frames_sent", "sent_frames", "Frames sent to the robot."),
    ("frames_received", "received_frames", "Frames from the robot."),
    ("retransmits", "retransmits", "Frames sent again."),
    ("crc_errors", "crc_errors", "Frames that arrived damaged."),
    ("lost", "links_lost", "Times the link was lost."),
    ("taken_back", "taken_back", "Times another host had the robot and fell silent."),
    ("stray_hellos", "stray_hellos", "Answers of the robot to a greeting not ours."),
    ("clock_jumps", "clock_jumps", "Jumps of the robot's clock or the host's."),
    ("stale", "stale", "Permits and poses too old to be sent."),
)


def _family(
    kind: type[GaugeMetricFamily | CounterMetricFamily], name: str, text: str, values: _Values
) -> Metric:
    family = kind(f"clearway_{name}", text, labels=[] if None in values else ["robot"])
    for robot, value in values.items():
        if value is not None:
            family.add_metric(_label(robot), float(value))
    return family


def _label(name: str | None) -> list[str]:
    return [] if name is None else [name]


_gauge_of: Final = partial(_family, GaugeMetricFamily)
_counter_of: Final = partial(_family, CounterMetricFamily)


def _gauge(name: str, text: str, value: float | bool | None) -> Metric:
    return _gauge_of(name, text, {None: value})


def _counter(name: str, text: str, value: float) -> Metric:
    return _counter_of(name, text, {None: value})


def _s(milliseconds: float | None) -> float | None:
    return None if milliseconds is None else milliseconds / 1e3
