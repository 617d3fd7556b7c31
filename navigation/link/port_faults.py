"""The errors of a serial port that breaks while it is open."""

from __future__ import annotations

from typing import Final

import serial


def _terminal_error() -> type[Exception]:
    try:
        import termios
    except ImportError:  # only Unix has it; elsewhere pyserial raises its own
        return serial.SerialException
    return termios.error


PORT_FAULTS: Final = (serial.SerialException, OSError, _terminal_error())
"""termios.error is no OSError, and pyserial lets it through after a hang-up."""
