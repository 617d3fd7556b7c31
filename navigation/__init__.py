"""Navigation Control: the running program.

The control loop is on this floor, from `eye` and `pilot` to `serial_link`; `daemon` turns it.
Around it, each in a folder: `config`, `draw`, `recording`, `simulator` and `machine` below;
`dashboard`, `run`, `sweep` and `cli` above.

What programs of your own may use is listed in ``__all__``. Names are imported on first use, so
that `clearway --help` needs none of them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from navigation.config.errors import ConfigError
    from navigation.config.load import load_config
    from navigation.config.sections import Config
    from navigation.draw.picture import DrawError, draw_svg, save_picture
    from navigation.link.link_snapshot import LinkSnapshot
    from navigation.link.serial_link import SerialLink
    from navigation.link.serial_port import PortError
    from navigation.mission.targets import targets_of, to_wire
    from navigation.simulator.robot import SimulatedRobot

__all__ = [
    "Config",
    "ConfigError",
    "DrawError",
    "LinkSnapshot",
    "PortError",
    "SerialLink",
    "SimulatedRobot",
    "draw_svg",
    "load_config",
    "save_picture",
    "targets_of",
    "to_wire",
]

_HOME = {
    "Config": "navigation.config.sections",
    "ConfigError": "navigation.config.errors",
    "DrawError": "navigation.draw.picture",
    "LinkSnapshot": "navigation.link.link_snapshot",
    "PortError": "navigation.link.serial_port",
    "SerialLink": "navigation.link.serial_link",
    "SimulatedRobot": "navigation.simulator.robot",
    "draw_svg": "navigation.draw.picture",
    "load_config": "navigation.config.load",
    "save_picture": "navigation.draw.picture",
    "targets_of": "navigation.mission.targets",
    "to_wire": "navigation.mission.targets",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'navigation' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
