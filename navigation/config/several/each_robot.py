"""Splits a configuration of several robots into one for each."""

from __future__ import annotations

from collections.abc import Iterator

from navigation.config.marks import Location
from navigation.config.sections import Config, MissionSection, RobotEntry
from navigation.config.simulation import SimulationSection
from navigation.config.values import Place, with_own


def each_robot(config: Config) -> dict[str, Config]:
    """Configuration of each of several robots as if it were alone, by name; else empty."""
    return {entry.name: _alone(config, i, entry) for i, entry in enumerate(config.robots)}


def named_places(
    mission: MissionSection, simulation: SimulationSection | None
) -> Iterator[tuple[Location, str, Place]]:
    """Yield each robot's start and stations, with their keys and its name."""
    for i, start in enumerate(simulation.starts if simulation is not None else ()):
        yield ("simulation", "starts", i), start.name, start
    for i, one in enumerate(mission.robots):
        for j, station in enumerate(one.stations):
            yield ("mission", "robots", i, "stations", j), one.name, station


def robots_of(config: Config) -> dict[str, Config]:
    """Each driven robot's configuration by name; a single robot has no name."""
    return each_robot(config) or {"": config}


def _alone(config: Config, index: int, entry: RobotEntry) -> Config:
    stations = [one.stations for one in config.mission.robots if one.name == entry.name]
    mission = config.mission.model_copy(
        update={"stations": stations[0] if stations else (), "robots": ()}
    )
    simulation = config.simulation
    if simulation is not None:
        starts = [one for one in simulation.starts if one.name == entry.name]
        start = starts[0] if starts else simulation.start
        seed = simulation.seed + index  # each robot has its own errors
        simulation = simulation.model_copy(update={"start": start, "starts": (), "seed": seed})
    zones = [zone for zone in config.zones if zone.is_for(entry.name)]
    journal = config.recording.journal
    if journal is not None and len(config.robots) > 1:
        journal = journal.with_name(f"{journal.name}.{entry.name}")
    return config.model_copy(
        update={
            "robot": with_own(config.robot, entry),
            "robots": (),
            "zones": tuple(zone.model_copy(update={"robots": ()}) for zone in zones),
            "serial": with_own(config.serial, entry),
            "mission": mission,
            "tasks": (),
            "simulation": simulation,
            "recording": config.recording.model_copy(update={"journal": journal}),
        }
    )


def settled(config: Config) -> Config:
    """The configuration itself, or for a list with a single robot that robot's own."""
    if len(config.robots) != 1:
        return config
    alone = each_robot(config)[config.robots[0].name]
    if config.tasks and not alone.mission.stations:
        mission = alone.mission.model_copy(update={"stations": config.tasks})
        return alone.model_copy(update={"mission": mission})
    return alone
