"""Every order that people may give, once.

A new order is a row here, and the method of `People` that it calls; the command line, the control
socket and the page then have it. Each row acts on one robot by name, or on all for None.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from navigation.mission.mission import MissionProgress, State

if TYPE_CHECKING:
    from navigation.loop.people import People

UNDER_WAY: Final = (State.PLANNING, State.PROVING, State.DRIVING, State.HOLDING)

Act: TypeAlias = "Callable[[People, str | None, Mapping[str, Any]], Mapping[str, Any] | None]"
"""Carries an order out for a robot; returns what the answer has beside the state."""


class Who(Enum):
    """People who may give an order on the page; the control socket takes every order."""

    ANYONE = "everybody with a token"
    OPERATOR = "the operator who holds the arena"
    SOCKET = "nobody on the page"


@dataclass(frozen=True, slots=True)
class Button:
    """An order's button on the page; ``why_not`` is empty if the order would do something."""

    label: str
    why_not: Callable[[MissionProgress], str]
    is_quiet: bool = True


@dataclass(frozen=True, slots=True)
class Order:
    """One order; ``example`` is a command line and its effect, ``arguments`` are request keys."""

    name: str
    summary: str
    help: str
    example: tuple[str, str]
    act: Act
    arguments: tuple[str, ...] = ()
    who: Who = Who.OPERATOR
    button: Button | None = None
    for_one: bool = False
    """True if a robot has to be named where there are several."""
    sets_going: bool = False
    """True if a robot may drive by it: the page never gives it to one that is stopped."""
    only_looks: bool = False
    """True if nothing changes by it."""
    may_repeat: bool = False
    """True if it may be sent again where no answer came."""
    command: str = ""
    """Command that gives it, if not the one of its name."""


def _stop(people: People, robot: str | None, given: Mapping[str, Any]) -> Mapping[str, Any]:
    trouble = people.stop(given["reason"], robot)
    return {"trouble": trouble} if trouble else {}


def _no_pause(mission: MissionProgress) -> str:
    if mission.paused:
        return "the mission is paused already"
    return "" if mission.state in UNDER_WAY else "nothing to pause: there is no mission under way"


def _no_resume(mission: MissionProgress) -> str:
    waits = mission.state in (State.IDLE, State.FAILED) and mission.visited < len(mission.stations)
    if mission.paused or waits:
        return ""
    return "nothing to resume: the mission is neither paused nor broken off"


def _no_replan(mission: MissionProgress) -> str:
    drives = mission.state is State.DRIVING
    return "" if drives else "nothing to plan again: the robot does not drive"


_ALL: Final = (
    Order(
        "go",
        "Send the running daemon's robot to a place.",
        "Drive to X,Y[,DEG], one or several, in metres of the arena.",
        (
            "clearway go 1.4,0.9 2.2,1.6,90 --dwell 0.5",
            "Send the robot to two places; at the second it faces 90 degrees.",
        ),
        lambda people, robot, given: people.give(given["stations"], robot),
        ("stations",),
        for_one=True,
        sets_going=True,
    ),
    Order(
        "stop",
        "Emergency stop of the running daemon's robot.",
        "Stop the robot at once; it stays stopped until `clearway resume` re-arms it.\n\n"
        "Of several robots all are stopped, or the one that --robot names; a name that none has\n"
        "stops all. A daemon is found even where its socket was removed; without --socket every\n"
        "daemon of yours is stopped then.",
        (
            'clearway stop --reason "a person in the arena"',
            "Stop the robot at once, and say why.",
        ),
        _stop,
        ("reason",),
        who=Who.ANYONE,
        may_repeat=True,
    ),
    Order(
        "pause",
        "Hold the robot where it is.",
        "Hold the robot until `clearway resume`.",
        ("clearway pause", "Hold the robot where it is."),
        lambda people, robot, _: people.pause(robot),
        button=Button("Pause", _no_pause, is_quiet=False),
    ),
    Order(
        "resume",
        "Continue after a pause; re-arm after a stop.",
        "Continue after a pause or a failed mission, with a new plan. After an emergency stop the "
        "first resume re-arms the robot, which does not move yet; a second one continues with the "
        "remaining stations, and `clearway go` gives new ones.",
        ("clearway resume", "Continue after a pause, or re-arm after a stop."),
        lambda people, robot, _: people.resume(robot),
        button=Button("Resume", _no_resume, is_quiet=False),
        sets_going=True,
    ),
    Order(
        "replan",
        "Plan the path again.",
        "Plan the mission again from where the robot is now.",
        ("clearway replan", "Plan again from where the robot is now."),
        lambda people, robot, _: people.replan(robot),
        button=Button("Plan again", _no_replan),
    ),
    Order(
        "skip",
        "Continue to the next station.",
        "Give up the station that the robot is on its way to, and continue to the next one. "
        "Without its last station the mission is done. A robot that is paused, re-armed or has "
        "failed stays so until `clearway resume`, and one that is stopped is re-armed first.",
        ("clearway skip", "Give up the present station, and continue to the next one."),
        lambda people, robot, _: people.skip(robot),
        button=Button("Skip", lambda mission: mission.cannot_skip),
        for_one=True,
    ),
    Order(
        "reanchor",
        "Place a moved camera by the floor markers.",
        "Place a moved camera again, by the floor markers of arena.floor_markers.",
        (
            "clearway reanchor arena.yaml floor.png",
            "Place the camera again by the floor markers in a picture.",
        ),
        lambda people, _, given: {"anchoring": people.reanchor(given["camera"])},
        ("camera",),
        who=Who.SOCKET,
        command="reanchor",
    ),
    Order(
        "status",
        "What the running daemon is doing.",
        "Print what the running daemon is doing, and why.",
        (
            "clearway status --format json",
            "Print state, reason and progress for a program to read.",
        ),
        lambda _people, _robot, _given: None,
        who=Who.SOCKET,
        only_looks=True,
        may_repeat=True,
    ),
    Order(
        "zone_put",
        "Add a zone, or replace the one of its name.",
        "Add a zone to the running program, or replace the one of its name.",
        (
            'clearway zone add desk --kind keep_out --polygon "0.5,0.5 1,0.5 1,1"',
            "Keep all robots off a desk.",
        ),
        lambda people, _, given: people.put_zone(given["zone"]),
        ("zone",),
        command="zone",
    ),
    Order(
        "zone_remove",
        "Remove a zone.",
        "Remove a zone of the running program.",
        ("clearway zone remove desk", "Let the robots drive there again."),
        lambda people, _, given: people.remove_zone(given["name"]),
        ("name",),
        command="zone",
    ),
    Order(
        "zone_undo",
        "Take back the last change of zones.",
        "Take back the last change of zones that was made while the program runs.",
        ("clearway zone undo", "Take back the last change of zones."),
        lambda people, _, given: people.undo_zone(given["revision"]),
        ("revision",),
        command="zone",
    ),
    Order(
        "zone_list",
        "List the zones in force.",
        "List the zones in force, and what differs from the configuration.",
        (
            "clearway zone list --format yaml",
            "Print the zones as a configuration has them.",
        ),
        lambda people, _robot, _given: people.zones(),
        who=Who.ANYONE,
        only_looks=True,
        may_repeat=True,
        command="zone",
    ),
)

ORDERS: Final[Mapping[str, Order]] = {one.name: one for one in _ALL}
"""By name, in the order in which people read them."""
