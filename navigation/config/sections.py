"""The sections of a configuration: arena, camera, ..., notify.

Units are SI and part of the names; angles are degrees, because people write them. The arena's
frame: metres, x right, y up, headings counter-clockwise from +x. The schema, the first file and
docs/configuration.md are made from these descriptions.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StrictBool

from navigation.config.dashboard import DashboardSection
from navigation.config.known_robots import OWN_LEAST_WHEEL_M_S, DriverName, ModelName
from navigation.config.notify import NotifySection
from navigation.config.recording import RecordingSection
from navigation.config.simulation import SimulationSection
from navigation.config.values import (
    MOST_CAMERAS,
    MOST_FLEET,
    MOST_ROBOTS,
    MOST_STATIONS,
    SIMULATED,
    ArenaSection,
    Count,
    Degrees,
    DriverUnits,
    ExposureTime,
    Fine,
    Fraction,
    Kelvin,
    LeastWheelSpeed,
    Length,
    Name,
    NeighbourFile,
    NotNegative,
    Number,
    Positive,
    Preference,
    Rate,
    Section,
    Source,
    StationSection,
    Text,
    as_in,
)
from navigation.config.zones import MOST_ZONES, ZoneSection
from vision.binarise import Method

Dictionary: TypeAlias = Literal[
    "DICT_4X4_50", "DICT_4X4_100", "DICT_4X4_250", "DICT_4X4_1000",
    "DICT_5X5_50", "DICT_5X5_100", "DICT_5X5_250", "DICT_5X5_1000",
    "DICT_6X6_50", "DICT_6X6_100", "DICT_6X6_250", "DICT_6X6_1000",
    "DICT_7X7_50", "DICT_7X7_100", "DICT_7X7_250", "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_ARUCO_MIP_36h12",
    "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10", "DICT_APRILTAG_36h11",
]  # fmt: skip


class CameraSection(Section):
    """The camera above the arena, and the conversion of its pixels to metres."""

    source: Source = Field(
        description="'simulated', a camera's number (0), a device (/dev/v4l/by-id/...), "
        "an rtsp:// or http:// address, a video file, a picture or a folder of pictures"
    )
    size_px: tuple[
        Annotated[int, Field(strict=True, ge=16, le=32768)],
        Annotated[int, Field(strict=True, ge=16, le=32768)],
    ] = Field(default=(1280, 960), description="[width, height] asked of the camera")
    rate_hz: Rate = Field(default=30.0, description="frames a second asked of the camera")
    calibration: NeighbourFile | None = Field(
        default=None,
        description="file written by `clearway calibrate`, relative to this file; "
        "empty with a simulated camera: its true values",
    )
    metres_per_pixel: Fine | None = Field(
        default=None,
        description="instead of a calibration: a camera looking straight down, no distortion, "
        "and markers on the floor (marker_height_m: 0)",
    )
    loop: StrictBool = Field(default=False, description="start a video file again at its end")
    format: Literal["auto", "mjpg", "yuyv", "grey"] = Field(
        default="auto",
        description="pixel format asked of a device; auto: raw where it reaches rate_hz, else mjpg",
    )
    exposure_ms: ExposureTime = Field(
        default="auto",
        description="exposure time of a device, or auto; against flicker a multiple of 10 "
        "(mains of 50 Hz) or 8.33 (60 Hz)",
    )
    gain: DriverUnits = Field(
        default="auto", description="gain of a device in its own units, or auto"
    )
    focus: DriverUnits = Field(
        default="auto", description="focus of a device in its own units, or auto"
    )
    white_balance_k: Kelvin = Field(
        default="auto", description="white balance of a device in kelvin, or auto"
    )
    mains_hz: Literal[50, 60] = Field(
        default=50,
        description="frequency of the mains that feed the lamps",
        json_schema_extra={"minimum": 50, "maximum": 60},
    )
    rolling_shutter_ms: Annotated[NotNegative, Field(le=1000)] = Field(
        default=0.0,
        description="time from the exposure of the first row to that of the last; 0: all at once",
    )


@as_in(CameraSection, leave_out=("metres_per_pixel",))
class CameraEntry(Section):
    """One of several cameras over one arena; an empty key is as in ``camera``."""

    name: Name = Field(description="what messages call it: letters, digits, _ and -")
    source: Source | None = Field(default=None, description="where its pictures come from")
    calibration: NeighbourFile | None = Field(
        default=None, description="its own file, of the same floor as the others'"
    )


class VisionSection(Section):
    """Separation of obstacles from the floor."""

    polarity: Literal["dark", "light"] = Field(
        default="dark", description="whether obstacles are darker or lighter than the floor"
    )
    method: Method = Field(default="auto", description="how the picture is made black and white")
    threshold: Annotated[Number, Field(ge=0, le=65535)] | None = Field(
        default=None, description="grey level for method 'fixed'"
    )


class MarkerSection(Section):
    """A robot as the camera sees it: its marker and its body."""

    marker_id: Count = Field(description="the number of the marker on the robot")
    marker_size_m: Length = Field(description="side of the marker's black square")
    marker_height_m: Annotated[NotNegative, Field(le=100)] = Field(
        default=0.0, description="height of the marker above the floor"
    )
    radius_m: Length = Field(
        description="radius of the disc around the marker's centre that holds the whole robot"
    )


class RobotSection(MarkerSection):
    """The driven robot: its marker, body, abilities and wheels."""

    driver: DriverName = Field(
        default="clearway",
        description="what it speaks: 'clearway' is our firmware, the others are named by robot",
    )
    model: ModelName | None = Field(
        default=None,
        description="which of the maker's robots it is, with driver 'waveshare' only: 'ugv01' (and "
        "the UGV Beast; empty: this one), or with the firmware for ROS 'ugv_rover' or 'rasp_rover'",
    )
    dictionary: Dictionary = Field(
        default="DICT_4X4_50", description="OpenCV's name of the marker family"
    )
    marker_turn_deg: Degrees = Field(
        default=0.0, description="how the marker is mounted: its x axis against the robot's forward"
    )
    speed_m_s: Rate = Field(default=0.3, description="highest speed")
    acceleration_m_s2: Rate = Field(default=0.5, description="highest acceleration and braking")
    lateral_acceleration_m_s2: Rate = Field(
        default=0.5, description="highest acceleration in bends"
    )
    jerk_m_s3: Rate = Field(default=5.0, description="highest change of acceleration")
    angular_rate_rad_s: Rate = Field(default=2.0, description="highest turning rate")
    angular_acceleration_rad_s2: Rate = Field(
        default=6.0, description="highest turning acceleration"
    )
    track_m: Length = Field(default=0.12, description="distance between the driven wheels")
    least_wheel_m_s: LeastWheelSpeed | None = Field(
        default=None,
        description="the slowest that a wheel at rest is sure to turn, measured on the floor: what "
        "is slower is driven in pulses of it; 0: wheels turn however slowly they are ordered to; "
        f"empty: {OWN_LEAST_WHEEL_M_S:g}, or what the driver's robot needs",
    )
    turns_on_spot: StrictBool = Field(
        default=True, description="whether it can turn without driving"
    )
    turning_radius_m: Annotated[NotNegative, Field(le=1000)] = Field(
        default=0.0,
        description="no bend is driven tighter; a tighter one is turned standing, or refused "
        "where the robot cannot",
    )


class PlanningSection(Section):
    """Choice of the path, and how to drive it."""

    margin_m: Annotated[NotNegative, Field(le=100)] = Field(
        default=0.01, description="kept free around the robot's radius in every plan"
    )
    margin: Literal["relaxed", "strict"] = Field(
        default="relaxed",
        description="a start or goal within the margin is left or reached on a short straight line "
        "that keeps the radius, which is said; 'strict': it is refused",
    )
    spacing_m: Length | None = Field(
        default=None,
        description="distance of the diagram's generators; empty: chosen from the radius",
    )
    prefer: Preference = Field(
        default="balanced",
        description="'clearance', 'length', 'balanced', or from 0 (length) to 1 (clearance)",
    )
    waypoint_spacing_m: Length = Field(
        default=0.05, description="largest distance between waypoints"
    )
    chord_tolerance_m: Fine = Field(
        default=0.002, description="how far the line between two waypoints may leave the path"
    )
    slow_clearance_m: Annotated[Positive, Field(le=1000)] = Field(
        default=0.20, description="below this clearance the robot drives more slowly"
    )
    slow_speed_m_s: Rate = Field(
        default=0.12, description="speed where the clearance is the robot's radius"
    )
    replan_distance_m: Annotated[NotNegative, Field(le=1000)] = Field(
        default=0.15,
        description="plan again when a changed obstacle is nearer than this to the path",
    )


class SerialSection(Section):
    """The line to the robot."""

    port: Text = Field(
        default=SIMULATED,
        description="'simulated', or a device; a name under /dev/serial/by-id survives replugging; "
        "with another robot.driver than 'clearway' also an address as socket://host:port",
    )
    baud: Annotated[int, Field(strict=True, ge=1200, le=4_000_000)] = Field(
        default=115_200, description="bits a second, as the robot's firmware has it"
    )


@as_in(SerialSection, RobotSection)
class RobotEntry(Section):
    """One of several driven robots; an empty key is as in ``robot`` and ``serial``."""

    name: Name = Field(description="what orders and reports call it: letters, digits, _ and -")
    marker_id: Count = Field(description="the number of the marker on this robot")


class SafetySection(Section):
    """Conditions in which the robot must hold or stop."""

    pose_stale_s: Positive = Field(
        default=0.2, description="hold when the marker was not seen for longer"
    )
    frame_stale_s: Positive = Field(default=0.2, description="hold when no picture came for longer")
    link_stale_s: Positive = Field(
        default=0.5, description="hold when the robot did not report for longer"
    )
    lease_s: Annotated[Positive, Field(le=0.5)] = Field(
        default=0.5,
        description="the robot stops by itself when the host was silent for longer; no robot "
        "waits more than half a second",
    )
    max_deviation_m: Positive = Field(
        default=0.05, description="hold and plan again when further off the path"
    )
    clearance_slack_m: NotNegative = Field(
        default=0.01,
        description="how far the measured clearance may be below the radius: camera error",
    )
    other_robots_m: Positive = Field(
        default=0.03, description="hold when another robot comes nearer than this to the body"
    )
    latency_s: Annotated[Positive, Field(le=0.3)] = Field(
        default=0.25,
        description="hold when the camera's pictures are older than this when they arrive, as "
        "driving shows; beyond 0.15 s the robot drives more slowly",
    )
    camera_moved_px: Annotated[NotNegative, Field(le=100)] = Field(
        default=2.0,
        description="hold when the picture's fixed points have moved by this: the camera was "
        "knocked; 0: it is not watched",
    )
    odometry_error: Fraction = Field(
        default=0.04,
        description="how wrong the wheels' metre may be, besides what is learned while driving: "
        "where camera and wheels differ by more, the robot holds and has to prove itself",
    )
    odometry_slack_m: Positive = Field(
        default=0.015, description="how far camera and wheels may differ in any case"
    )
    cameras_apart_m: Positive = Field(
        default=0.02,
        description="hold when two cameras see the same outlines farther apart than this, and stop "
        "when they see the robot's marker so: their calibrations are not of one floor",
    )
    give_up_s: Positive = Field(
        default=30.0,
        description="the mission fails when the robot had to wait for longer without progress",
    )


class RobotMissionSection(Section):
    """Stations of one of several robots."""

    name: Name = Field(description="which of robots it is")
    stations: tuple[StationSection, ...] = Field(
        default=(), max_length=MOST_STATIONS, description="places to visit; the last is the goal"
    )


class MissionSection(Section):
    """Stations of the mission; without them the program waits for orders."""

    stations: tuple[StationSection, ...] = Field(
        default=(),
        max_length=MOST_STATIONS,
        description=f"places to visit, at most {MOST_STATIONS}; the last is the goal",
    )
    order: Literal["fixed", "best"] = Field(
        default="fixed", description="as written, or the shortest order (the last stays the goal)"
    )
    robots: tuple[RobotMissionSection, ...] = Field(
        default=(),
        max_length=MOST_FLEET,
        description="with several robots: the stations of each, by name",
    )
    tolerance_m: Annotated[Positive, Field(le=10)] = Field(
        default=0.01, description="how near to a station counts as there"
    )
    tolerance_deg: Annotated[Positive, Field(le=360)] = Field(
        default=2.0, description="how near to its heading counts as turned"
    )


class Config(Section):
    """A whole configuration."""

    arena: ArenaSection = Field(description="the free space")
    camera: CameraSection = Field(description="the camera above it")
    cameras: tuple[CameraEntry, ...] = Field(
        default=(),
        max_length=MOST_CAMERAS,
        description="several cameras that see one arena together: for each its name and what "
        "differs from `camera`",
    )
    vision: VisionSection = Field(default=VisionSection(), description="seeing obstacles")
    robot: RobotSection = Field(description="the robot that is driven")
    robots: tuple[RobotEntry, ...] = Field(
        default=(),
        max_length=MOST_FLEET,
        description="several robots that are driven together, none of which ever touches another: "
        "for each its name and what differs from `robot` and `serial`",
    )
    other_robots: tuple[MarkerSection, ...] = Field(
        default=(),
        max_length=MOST_ROBOTS,
        description=f"robots that drive by themselves: moving obstacles, at most {MOST_ROBOTS}",
    )
    zones: tuple[ZoneSection, ...] = Field(
        default=(),
        max_length=MOST_ZONES,
        description=f"areas with rules: keep out, slow, one way, lane, wait; at most {MOST_ZONES}",
    )
    planning: PlanningSection = Field(default=PlanningSection(), description="choosing the path")
    serial: SerialSection = Field(default=SerialSection(), description="the line to the robot")
    safety: SafetySection = Field(default=SafetySection(), description="holding and stopping")
    mission: MissionSection = Field(default=MissionSection(), description="where to go")
    tasks: tuple[StationSection, ...] = Field(
        default=(),
        max_length=MOST_STATIONS,
        description="with several robots: places for whichever robot is best placed, at most one "
        "for each robot without stations of its own",
    )
    simulation: SimulationSection | None = Field(
        default=None, description="the simulated world; needed where camera or port is simulated"
    )
    recording: RecordingSection = Field(
        default=RecordingSection(), description="what a run leaves behind"
    )
    dashboard: DashboardSection = Field(
        default=DashboardSection(), description="the page that shows the arena and takes orders"
    )
    notify: NotifySection = Field(
        default=NotifySection(),
        description="what is called when a robot's mission is done, stopped or failed",
    )
