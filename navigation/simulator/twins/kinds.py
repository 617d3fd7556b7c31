"""Twins of other makers' robots by name, and their simulated wheels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from navigation.simulator.drive_model import DriveModel
from navigation.simulator.line_faults import FaultSpec, FaultSpecError
from navigation.simulator.twins.create2 import Create2Twin
from navigation.simulator.twins.epuck2 import Epuck2Twin
from navigation.simulator.twins.turtlebot3 import Turtlebot3Twin
from navigation.simulator.twins.twin import Twin
from navigation.simulator.twins.waveshare import WaveshareTwin

TWINS: Final[Mapping[str, Callable[[], Twin]]] = {
    "create2": Create2Twin,
    "turtlebot3": Turtlebot3Twin,
    "epuck2": Epuck2Twin,
    "waveshare": WaveshareTwin,
}


def wheels_of(twin: Twin, model: DriveModel) -> DriveModel:
    """Combine the model's errors with the twin's mechanics; its track error stays."""
    return replace(model, ticks_per_m=twin.body.ticks_per_m, max_wheel_m_s=twin.body.wheel_m_s)


def refuse_frame_faults(faults: FaultSpec) -> None:
    """Raise ``FaultSpecError`` for faults of whole frames, which only Clearway's line has."""
    for name in ("dup", "swap", "span"):
        if getattr(faults, name) > 0.0:
            raise FaultSpecError(
                f"fault {name}: is about the frames of Clearway's own line; "
                "other robots take drop, flip, noise, stall, reset and freeze"
            )
