"""C header from a configuration, for building a robot's firmware.

    python -m navigation.loop.firmware_settings configs/simulation.yaml -o my_robot.h
    make -C firmware_protocol/firmware avr SETTINGS=$PWD/my_robot.h

Track, speeds and accelerations come from the section ``robot``, the baud rate from ``serial``. Give
the encoders' resolution and the wheels' speed at full power here: no other part of the program
needs them, so no configuration has them. ``firmware/settings.h`` has the defaults.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from navigation.config import Config, load_config
from navigation.simulator.settings import drive_settings_of

UM_PER_STEP = 250
FULL_SPEED_MM_S = 800


def header_of(config: Config, um_per_step: int, full_speed_mm_s: int) -> str:
    """Text of the header; micrometres, then mm, mrad and ms, as in ``cw_settings``."""
    track_um, *others = drive_settings_of(config).whole_numbers()
    values = ", ".join([f"{track_um}ul", *(f"{value}u" for value in others)])
    lines = [
        "/* Made by python -m navigation.loop.firmware_settings from a configuration. */",
        "#ifndef CLEARWAY_MY_ROBOT_H",
        "#define CLEARWAY_MY_ROBOT_H",
        "",
        f"#define CW_SETTINGS {{{values}}}",
        f"#define CW_BAUD {config.serial.baud}ul",
        f"#define CW_UM_PER_STEP {um_per_step}l",
        f"#define CW_FULL_SPEED_MM_S {full_speed_mm_s}ul",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the header; see the module's text."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("config", type=Path)
    arguments.add_argument("--um-per-step", type=int, default=UM_PER_STEP)
    arguments.add_argument("--full-speed-mm-s", type=int, default=FULL_SPEED_MM_S)
    arguments.add_argument("-o", "--output", type=Path, required=True)
    given = arguments.parse_args()
    text = header_of(load_config(given.config), given.um_per_step, given.full_speed_mm_s)
    given.output.write_text(text)


if __name__ == "__main__":
    main()
