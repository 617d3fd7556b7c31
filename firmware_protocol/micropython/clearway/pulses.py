"""Wheels that do not turn below a least speed: what is slower, they are driven in pulses of it. The
twin of ``pulses.c``; ``wheel_pulses.py`` of the Python robot says why.
"""

from .native import micropython

PULSE_US = 25000


@micropython.native
def pulsed(least: int, order: int, driven: int, owed: int, ahead: bool) -> int:
    """What to drive a wheel at that is ordered to turn at ``order``, in eighths of mm/s."""
    if order == 0 or abs(order) >= least:
        return order
    pulse = least * PULSE_US
    if order < 0:
        owed, driven, least = -owed, -driven, -least
    if ahead:
        owed += pulse >> 1
    return least if owed >= pulse or (driven > 0 and owed > 0) else 0
