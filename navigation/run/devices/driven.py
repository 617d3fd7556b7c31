"""Robots with another protocol, opened through their driver."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from navigation.config import Config
from navigation.config.known_robots import CLEARWAY
from navigation.link.drivers.driver_link import DriverLink
from navigation.link.drivers.driver_process import DriverProcess
from navigation.simulator.settings import drive_settings_of


def driver_of(config: Config, robot_port: str) -> DriverProcess | None:
    """Return the configured driver, not started; None for our own firmware."""
    if config.robot.driver == CLEARWAY:
        return None
    return DriverProcess(
        config.robot.driver,
        robot_port,
        config.serial.baud,
        drive_settings_of(config),
        config.robot.model,
    )


def link_of(driver: DriverProcess, clock: Callable[[], float]) -> DriverLink:
    """Make the link to a driver's process."""
    return DriverLink(driver.port, driver.word, clock=clock)


def start_all(drivers: Iterable[DriverProcess]) -> None:
    """Start all drivers together; PortNotReadyError if one does not start."""
    drivers = list(drivers)
    for driver in drivers:
        driver.begin()
    for driver in drivers:
        driver.start()


def end_all(drivers: Iterable[DriverProcess]) -> list[str]:
    """End all drivers together; return the doubts about their robots."""
    drivers = list(drivers)
    for driver in drivers:
        driver.end()
    return [doubt for driver in drivers if (doubt := driver.stop()) is not None]
