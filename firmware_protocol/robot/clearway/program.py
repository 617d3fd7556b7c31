"""The program of any board: take bytes, answer, and run one control cycle every 10 ms.

A board is an object with these methods, none of which waits:

- ``read(buffer)``: puts arrived bytes into the buffer; returns their number
- ``can_write()``, ``write(view)``: one frame; the view is untouched until it can again
- ``travel_um(side)``: the wheel's (0 left, 1 right) travel since the last call
- ``drive(left, right, powered)``: speeds in eighths of mm/s; forward is positive on both sides
- ``stop_pressed()``: True if a button asks for a stop
- ``idle(powered)``: feed a watchdog; collect garbage while the motors are unpowered
"""

from .estimate import TIME
from .link import Link
from .robot import ESTOP_LOCAL, Robot
from .settings import Settings

CONTROL_US = 10000
LEAP_UM = 0x100000


class Program:
    """One boot: ``clock_us`` is a free-running clock, modulo 2^30 or a multiple of it.

    Read at least every 9 minutes, or the line's 32-bit time loses its upper two bits.
    """

    def __init__(self, board, settings: Settings, clock_us, boot_id: int) -> None:  # type: ignore[no-untyped-def]
        self.robot = Robot(settings)
        self.link = Link(self.robot, boot_id)
        self._board = board
        self._clock_us = clock_us
        self._arrived = bytearray(64)
        # a slice of a view allocates: make all of them here
        view = memoryview(self.link.frame)
        self._frames = [view[:size] for size in range(len(self.link.frame) + 1)]
        self._now_us = self._stepped_us = clock_us() & TIME

    def _read_clock(self) -> int:
        """Read the clock. A jump back by over half a turn is a wrap; a smaller one, a clock set
        back."""
        now_us = self._clock_us() & TIME
        if self._now_us - now_us > TIME >> 1:
            self.link.turns = self.link.turns + 1 & 3
        elif now_us - self._now_us > TIME >> 1:
            self.link.turns = self.link.turns - 1 & 3  # set back over the turn
        self._now_us = now_us
        return now_us

    def round(self) -> None:
        """Run one round; call it without a pause."""
        board, link, robot = self._board, self.link, self.robot
        now_us = self._read_clock()
        count = board.read(self._arrived)
        while count:
            link.receive(self._arrived, count, now_us)
            count = board.read(self._arrived)
        if board.stop_pressed():
            robot.emergency_stop(ESTOP_LOCAL)
        if board.can_write():
            size = link.next_frame(now_us)
            if size:
                board.write(self._frames[size])
        robot.tick(now_us)
        late = now_us - self._stepped_us & TIME
        if robot.hurry or late >= CONTROL_US:
            if late >= CONTROL_US:
                # do not make up for a long delay
                behind = late > 10 * CONTROL_US
                self._stepped_us = now_us if behind else self._stepped_us + CONTROL_US & TIME
            left_um = max(-LEAP_UM, min(LEAP_UM, board.travel_um(0)))
            right_um = max(-LEAP_UM, min(LEAP_UM, board.travel_um(1)))
            robot.step(now_us, left_um, right_um)
        else:
            robot.sum()
        board.drive(robot.left, robot.right, robot.powered)

    def run(self) -> None:
        """Run for ever; however it ends, the motors are off."""
        try:
            while True:
                self.round()
                self._board.idle(self.robot.powered)
        finally:
            self._board.drive(0, 0, False)
