"""The program of any board: take what has arrived, answer, and every 10 ms do one control cycle.

A board is an object with these methods, none of which waits:

- ``read(buffer)``: bytes that have arrived, into the buffer; how many
- ``can_write()``, ``write(view)``: one frame at a time; the view stays untouched until it can again
- ``travel_um(side)``: what the wheel (0 left, 1 right) has travelled since the last call
- ``drive(left, right, powered)``: speeds in eighths of mm/s; forward is positive on both sides
- ``stop_pressed()``: True if a button asks for a stop
- ``idle(powered)``: feed a watchdog; where the motors have no power, time for the garbage collector
"""

from .estimate import TIME
from .link import Link
from .robot import ESTOP_LOCAL, Robot
from .settings import Settings

CONTROL_US = 10000
LEAP_UM = 0x100000


class Program:
    """One boot: ``clock_us`` is a free-running clock, modulo 2^30 or a multiple of it.

    It is read at least every 9 minutes, or the line's time, which has 32 bits, loses its upper two.
    """

    def __init__(self, board, settings: Settings, clock_us, boot_id: int) -> None:  # type: ignore[no-untyped-def]
        self.robot = Robot(settings)
        self.link = Link(self.robot, boot_id)
        self._board = board
        self._clock_us = clock_us
        self._arrived = bytearray(64)
        # a slice of a view allocates: all that will be needed are made here
        view = memoryview(self.link.frame)
        self._frames = [view[:size] for size in range(len(self.link.frame) + 1)]
        self._now_us = self._stepped_us = clock_us() & TIME

    def _read_clock(self) -> int:
        """The time now. Half a turn back is a turn come round; a clock that is set back is none."""
        now_us = self._clock_us() & TIME
        if self._now_us - now_us > TIME >> 1:
            self.link.turns = self.link.turns + 1 & 3
        elif now_us - self._now_us > TIME >> 1:
            self.link.turns = self.link.turns - 1 & 3  # set back over the turn
        self._now_us = now_us
        return now_us

    def round(self) -> None:
        """To be called without a pause."""
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
                # a processor that was busy for long does not make up for it
                behind = late > 10 * CONTROL_US
                self._stepped_us = now_us if behind else self._stepped_us + CONTROL_US & TIME
            left_um = max(-LEAP_UM, min(LEAP_UM, board.travel_um(0)))
            right_um = max(-LEAP_UM, min(LEAP_UM, board.travel_um(1)))
            robot.step(now_us, left_um, right_um)
        else:
            robot.sum()
        board.drive(robot.left, robot.right, robot.powered)

    def run(self) -> None:
        """For ever; the motors are off when it ends, whatever ends it."""
        try:
            while True:
                self.round()
                self._board.idle(self.robot.powered)
        finally:
            self._board.drive(0, 0, False)
