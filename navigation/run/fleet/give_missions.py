"""The configured missions, each to its robot; tasks once it is known where all robots are."""

from __future__ import annotations

from navigation.loop.fleet.fleet_daemon import FleetDaemon
from navigation.loop.stages import stations_of


def give_missions(daemon: FleetDaemon) -> None:
    """Give every robot its configured stations, and the fleet its tasks."""
    for name, seat in daemon.seats.items():
        stations = stations_of(seat.config)
        if stations:
            daemon.give(stations, name)
