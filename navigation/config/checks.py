"""Checks across a configuration's keys and sections.

Each gets sections that are already valid, and yields the place of a contradiction and a sentence.
One of `robot` or `serial` that does not take `robots` is made for each robot.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from typing import Any, Final

from navigation.config.known_robots import CLEARWAY, KNOWN_ROBOTS
from navigation.config.marks import Location
from navigation.config.sections import MarkerSection
from navigation.config.several import camera_checks, fleet_checks
from navigation.config.several.each_robot import named_places
from navigation.config.values import SIMULATED, Place, with_own
from navigation.config.zones import zone_checks

MOST_STEPS = 1_000_000
"""Generators along an arena's walls, and waypoints once around it."""

_Found = Iterator[tuple[Location, str]]
_HOLDS: Final = {"<": operator.lt, "<=": operator.le, ">=": operator.ge}


def _limited(
    where: Location, value: float, sign: str, limit: float, why: str, digits: int = 6
) -> _Found:
    """Yield the sentence on a value beyond a limit; ``why`` follows the limit."""
    if not _HOLDS[sign](value, limit):
        yield where, f"must be {sign} {limit:.{digits}g}{why}, not {value:g}"


def bounds_have_an_inside(arena: Any) -> _Found:
    """An arena has an area."""
    x0, y0, x1, y1 = arena.bounds_m
    if not (x0 < x1 and y0 < y1):
        yield ("arena", "bounds_m"), "must be [x_min, y_min, x_max, y_max] with min < max"


def _camera_has_a_scale(camera: Any, cameras: Any) -> _Found:
    if cameras:
        return  # each camera is checked by itself
    if camera.calibration is not None and camera.metres_per_pixel is not None:
        yield ("camera", "metres_per_pixel"), "must not be given beside a calibration"
    if camera.source != SIMULATED and camera.calibration is None and not camera.metres_per_pixel:
        yield (
            ("camera",),
            "needs a calibration (`clearway calibrate` makes one) or metres_per_pixel",
        )
    if camera.source == SIMULATED and camera.rolling_shutter_ms > 0.0:
        told = f"must be 0, not {camera.rolling_shutter_ms:g}: the simulated camera has none"
        yield ("camera", "rolling_shutter_ms"), told


def _fixed_has_a_threshold(vision: Any) -> _Found:
    if vision.method == "fixed" and vision.threshold is None:
        yield ("vision", "method"), "'fixed' needs a threshold"
    if vision.method != "fixed" and vision.threshold is not None:
        yield ("vision", "threshold"), f"is used by method 'fixed' only, not '{vision.method}'"


def _robot_fits_together(robot: Any) -> _Found:
    yield from _marker_lies_on_the_body(robot, ("robot",))
    width_m = 2 * robot.radius_m
    yield from _limited(("robot", "track_m"), robot.track_m, "<=", width_m, ", the body's width")


def _wheels_can_crawl(robot: Any) -> _Found:
    where, least = ("robot", "least_wheel_m_s"), robot.least_wheel_m_s
    if least is not None:
        yield from _limited(where, least, "<", robot.speed_m_s, ", robot.speed_m_s")


def _driver_can_drive_it(robot: Any, serial: Any) -> _Found:
    models = () if robot.driver == CLEARWAY else KNOWN_ROBOTS[robot.driver].models
    if robot.model is not None and robot.model not in models:
        yield (
            ("robot", "model"),
            f"'{robot.model}' is no model for robot.driver '{robot.driver}': leave it out",
        )
    if robot.driver == CLEARWAY:
        if "://" in serial.port:
            yield ("serial", "port"), "an address needs a robot.driver other than 'clearway'"
        return
    known = KNOWN_ROBOTS[robot.driver]
    turn_rad_s = 2 * known.wheel_m_s / robot.track_m
    wheels = f", the {known.title}'s wheels at {known.wheel_m_s:g} m/s"
    for key, value, sign, limit, why in (
        ("speed_m_s", robot.speed_m_s, "<=", known.speed_m_s, f", the {known.title}'s"),
        ("angular_rate_rad_s", robot.angular_rate_rad_s, "<=", turn_rad_s, wheels),
        ("radius_m", robot.radius_m, ">=", known.radius_m, f", the {known.title}'s body"),
    ):
        yield from _limited(("robot", key), value, sign, limit, why, digits=4)


def _marker_lies_on_the_body(robot: MarkerSection, where: Location) -> _Found:
    limit, why = robot.radius_m * 2**0.5, f" to lie on the body of radius {robot.radius_m:g}"
    yield from _limited((*where, "marker_size_m"), robot.marker_size_m, "<=", limit, why, digits=4)


def _robots_differ(robot: Any, robots: Any, other_robots: Any) -> _Found:
    taken = {} if robots else {robot.marker_id: "the driven robot"}
    for index, other in enumerate(other_robots):
        yield from _marker_lies_on_the_body(other, ("other_robots", index))
        if other.marker_id in taken:
            owner = taken[other.marker_id]
            yield ("other_robots", index, "marker_id"), f"{other.marker_id} is {owner}'s already"
        taken[other.marker_id] = f"other_robots[{index}]"


def _dictionary_holds_the_markers(robot: Any, other_robots: Any) -> _Found:
    size = dictionary_size(robot.dictionary)
    marked: list[tuple[Location, int]] = [(("robot", "marker_id"), robot.marker_id)]
    marked += [(("other_robots", i, "marker_id"), o.marker_id) for i, o in enumerate(other_robots)]
    for where, marker_id in marked:
        if marker_id >= size:
            yield where, f"must be < {size} in {robot.dictionary}, not {marker_id}"


_APRILTAG_SIZES = {"16h5": 30, "25h9": 35, "36h10": 2320, "36h11": 587, "36h12": 250}


def dictionary_size(name: str) -> int:
    """Number of markers in an OpenCV dictionary."""
    if name == "DICT_ARUCO_ORIGINAL":
        return 1024
    kind = name.rsplit("_", 1)[1]
    return _APRILTAG_SIZES[kind] if kind in _APRILTAG_SIZES else int(kind)


def _floor_markers_can_be_told_apart(
    arena: Any, robot: Any, robots: Any, other_robots: Any
) -> _Found:
    seen = {one.marker_id for one in (*(robots or (robot,)), *other_robots)}
    size = dictionary_size(robot.dictionary)
    for index, one in enumerate(arena.floor_markers):
        where: Location = ("arena", "floor_markers", index, "marker_id")
        if one.marker_id in seen:
            yield where, f"{one.marker_id} is a robot's or another floor marker's"
        if one.marker_id >= size:
            yield where, f"must be < {size} in {robot.dictionary}, not {one.marker_id}"
        if one.heading_deg is not None and one.place_m is None:
            yield ("arena", "floor_markers", index, "heading_deg"), "needs place_m beside it"
        seen.add(one.marker_id)


def _speeds_agree(robot: Any, planning: Any) -> _Found:
    where, limit = ("planning", "slow_speed_m_s"), robot.speed_m_s
    yield from _limited(where, planning.slow_speed_m_s, "<=", limit, ", robot.speed_m_s")


def _spacing_is_fine_enough(robot: Any, planning: Any) -> _Found:
    if planning.spacing_m is not None:
        where, limit = ("planning", "spacing_m"), 2 * robot.radius_m
        yield from _limited(where, planning.spacing_m, "<", limit, ", twice the robot's radius")


def _robot_fits_into_the_arena(arena: Any, robot: Any) -> _Found:
    """Its bends too."""
    x0, y0, x1, y1 = arena.bounds_m
    short, long = sorted((x1 - x0, y1 - y0))
    if short > 0.0:
        where, why = ("robot", "radius_m"), ", half the arena's shorter side"
        yield from _limited(where, robot.radius_m, "<=", short / 2, why)
    if long > 0.0:
        where, why = ("robot", "turning_radius_m"), ", the arena's longer side"
        yield from _limited(where, robot.turning_radius_m, "<=", long, why)


def _plans_stay_small(arena: Any, robot: Any, planning: Any) -> _Found:
    """The walls alone need a generator every spacing."""
    x0, y0, x1, y1 = arena.bounds_m
    if not (x0 < x1 and y0 < y1):
        return
    around_m = 2 * (x1 - x0 + y1 - y0)
    spacing_m = robot.radius_m if planning.spacing_m is None else planning.spacing_m
    where: Location = ("robot", "radius_m")
    if planning.spacing_m is not None:
        where = ("planning", "spacing_m")
    for place, step_m in (
        (where, spacing_m),
        (("planning", "waypoint_spacing_m"), planning.waypoint_spacing_m),
    ):
        limit, why = around_m / MOST_STEPS, " in an arena of this size"
        yield from _limited(place, step_m, ">=", limit, why, digits=4)


def _places_lie_inside(arena: Any, robot: Any, mission: Any, simulation: Any) -> _Found:
    places: list[tuple[Location, Place]] = [
        (("mission", "stations", index), station) for index, station in enumerate(mission.stations)
    ]
    if simulation is not None and simulation.start is not None:
        places.append((("simulation", "start"), simulation.start))
    yield from _inside(arena, robot, places)


def _inside(arena: Any, robot: Any, places: list[tuple[Location, Place]]) -> _Found:
    x0, y0, x1, y1 = arena.bounds_m
    if not (x0 < x1 and y0 < y1):
        return
    r = robot.radius_m
    if 2 * r > min(x1 - x0, y1 - y0):
        return
    for where, place in places:
        for key, value, low, high in (
            ("x_m", place.x_m, x0 + r, x1 - r),
            ("y_m", place.y_m, y0 + r, y1 - r),
        ):
            if not low <= value <= high:
                yield (
                    (*where, key),
                    f"must be in {low:g}..{high:g} for a robot of radius {r:g} "
                    f"inside the arena, not {value:g}",
                )


def _simulation_is_there(
    camera: Any, cameras: Any, serial: Any, robots: Any, simulation: Any
) -> _Found:
    if simulation is not None:
        return
    used: list[tuple[Location, Any]] = [(("camera", "source"), camera.source)]
    used += [(("cameras", i, "source"), one.source) for i, one in enumerate(cameras)]
    used += [(("serial", "port"), serial.port)]
    used += [(("robots", i, "port"), one.port) for i, one in enumerate(robots)]
    for where, value in used:
        if value == SIMULATED:
            yield where, "'simulated' needs a section 'simulation'"


def _simulation_has_one_arena(simulation: Any) -> _Found:
    if simulation is None:
        return
    if simulation.arena is None and simulation.arena_text is None:
        yield ("simulation",), "needs an arena (a scene text file) or arena_text"
    if simulation.arena is not None and simulation.arena_text is not None:
        yield ("simulation", "arena_text"), "must not be given beside an arena file"


def _simulated_robots_are_known(other_robots: Any, simulation: Any) -> _Found:
    known = {other.marker_id for other in other_robots}
    for index, one in enumerate(() if simulation is None else simulation.other_robots):
        if one.marker_id not in known:
            yield (
                ("simulation", "other_robots", index, "marker_id"),
                f"{one.marker_id} is none of other_robots: {sorted(known) or 'there are none'}",
            )


def _happenings_end_after_they_begin(simulation: Any) -> _Found:
    if simulation is None:
        return
    for where, happenings in (
        (("simulation", "obstacles"), simulation.obstacles),
        (("simulation", "camera", "knocks"), simulation.camera.knocks),
        *(
            (("simulation", "cameras", number, "knocks"), one.knocks or ())
            for number, one in enumerate(simulation.cameras)
        ),
    ):
        for index, one in enumerate(happenings):
            if one.until_s is not None and one.until_s <= one.from_s:
                yield (
                    (*where, index, "until_s"),
                    f"must be > {one.from_s:g}, its from_s, not {one.until_s:g}",
                )


def _places_of_each_lie_inside(
    arena: Any, robot: Any, robots: Any, mission: Any, simulation: Any
) -> _Found:
    for entry in robots:
        own = [
            (at, one) for at, name, one in named_places(mission, simulation) if name == entry.name
        ]
        yield from _inside(arena, with_own(robot, entry), own)


def _lease_outlives_the_pose(safety: Any) -> _Found:
    limit, why = safety.pose_stale_s, ", safety.pose_stale_s"
    yield from _limited(("safety", "lease_s"), safety.lease_s, ">=", limit, why)


def _strangers_need_a_token(dashboard: Any) -> _Found:
    if dashboard.enabled and not dashboard.is_local and dashboard.token is None:
        yield (
            ("dashboard", "host"),
            f"others can reach {dashboard.host}: needs dashboard.token (at least 16 characters)",
        )
    taken = {dashboard.token: "dashboard.token"}
    for key in ("viewer_token", "supervisor_token"):
        token = getattr(dashboard, key)
        if token is None:
            continue
        if dashboard.token is None:
            yield ("dashboard", key), "needs dashboard.token for those who drive"
        if token in taken:
            yield ("dashboard", key), f"must differ from {taken[token]}"
        taken[token] = f"dashboard.{key}"


def _one_is_notified(notify: Any) -> _Found:
    if notify.command is not None and notify.url is not None:
        yield ("notify", "url"), "must not be given beside notify.command"


CHECKS: tuple[tuple[tuple[str, ...], Callable[..., _Found]], ...] = (
    (("arena",), bounds_have_an_inside),
    (("camera", "cameras"), _camera_has_a_scale),
    (("camera", "cameras"), camera_checks.names_and_sources_differ),
    (("camera", "cameras"), camera_checks.each_has_a_calibration),
    (("arena", "cameras"), camera_checks.markers_of_several_have_places),
    (("cameras", "simulation"), camera_checks.simulated_cameras_are_known),
    (("vision",), _fixed_has_a_threshold),
    (("robot",), _robot_fits_together),
    (("robot",), _wheels_can_crawl),
    (("robot", "serial"), _driver_can_drive_it),
    (("robot", "robots", "other_robots"), _robots_differ),
    (("robot", "other_robots"), _dictionary_holds_the_markers),
    (("arena", "robot", "robots", "other_robots"), _floor_markers_can_be_told_apart),
    (("robot", "planning"), _speeds_agree),
    (("robot", "planning"), _spacing_is_fine_enough),
    (("arena", "robot"), _robot_fits_into_the_arena),
    (("arena", "robot", "planning"), _plans_stay_small),
    (("arena", "robot", "mission", "simulation"), _places_lie_inside),
    (("robots", "serial", "other_robots"), fleet_checks.names_markers_and_ports_differ),
    (("robots", "recording"), fleet_checks.journals_differ),
    (("robots", "robot"), fleet_checks.markers_are_of_one_family),
    (("robots", "mission", "simulation"), fleet_checks.names_are_known),
    (("robots", "serial", "simulation"), fleet_checks.every_robot_has_a_start),
    (("robots", "mission", "tasks"), fleet_checks.missions_fit_the_fleet),
    (("robots", "robot", "mission"), fleet_checks.goals_do_not_touch),
    (("robots", "robot", "simulation"), fleet_checks.starts_do_not_touch),
    (("arena", "robot", "robots", "mission", "simulation"), _places_of_each_lie_inside),
    (("camera", "cameras", "serial", "robots", "simulation"), _simulation_is_there),
    (("simulation",), _simulation_has_one_arena),
    (("other_robots", "simulation"), _simulated_robots_are_known),
    (("simulation",), _happenings_end_after_they_begin),
    (("zones",), zone_checks.zone_names_differ),
    (("zones",), zone_checks.zones_have_few_places),
    (("zones", "robots"), zone_checks.zones_are_for_known_robots),
    (("arena", "zones"), zone_checks.zones_lie_in_the_arena),
    (("safety",), _lease_outlives_the_pose),
    (("dashboard",), _strangers_need_a_token),
    (("notify",), _one_is_notified),
)
