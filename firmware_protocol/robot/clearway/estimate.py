"""The robot's pose: wheel odometry, corrected by camera poses that are already old.

- Odometry moves the estimate at every step; a short history records it uncorrected.
- The wheels' motion since a fix is added to it; a quarter of the difference is taken over.
- Unequal wheels turn the robot as it drives: that drift is learnt from the fixes.
- Micrometres; the heading, 2^32 a turn, is kept in two halves, the upper of which is the angle used
  elsewhere. The history has 16 bits each: 256 um, 2^16 a turn, 256 us.

The twin of ``estimate.c``.
"""

from array import array

from .fixed import VECTOR, clip, scale, short, turn, word
from .native import micropython
from .wire import get_place

DRIFT_MAX = 419904
"""Angle per micrometre, times 1024: 0.6 rad/m, wheels that differ by 7 % on 0.12 m."""
TRAVEL_MAX = 1 << 29
"""537 m, the most travel counted since the last fix: with a cycle's, 1 m at most, it stays below
2^30. No drift is learnt from it."""
HISTORY = 9
HISTORY_STEP = 156
"""40 ms."""
JUMP_UM = 150000
JUMP_SHIFT = 11
"""Shift of a heading of 32 bits that compares it with JUMP_UM: 0.45 rad."""
JUMPS_BELIEVED = 5
"""Far-off fixes in a row that mean a robot moved by hand."""
TIME = 0x3FFFFFFF
"""Times are microseconds modulo 2^30."""
X, Y, TOP, LOW = 0, 1, 2, 3


class Estimate:
    """The pose and its corrections."""

    def __init__(self, track_um: int) -> None:
        self.pose = array("i", (0, 0, 0, 0))
        """x and y in micrometres; the heading's upper and lower half."""
        self._moved = array("i", (0, 0, 0, 0))
        """The same uncorrected; x and y modulo 2^24."""
        self.known = False
        self.fix_recent = False
        self.fix_us = 0
        self.travel_um = 0
        self._angle_per_um = (683565276 + track_um // 2) // track_um
        self._drift = 0
        self._jumps = 0
        # the newest first: x and y in 256 um, the angle, the time in 256 us
        self._past = array("H", bytes(8 * HISTORY))
        self._shift = array("i", (0, 0, 0, 0))

    @micropython.native
    def advance(self, travel_um: int, across_um: int, now_us: int) -> None:
        """Move by a cycle's travel; ``across_um`` is the right wheel's minus the left one's."""
        past = self._past
        if (past[3] - past[7]) & 0xFFFF >= HISTORY_STEP:
            for i in range(4 * HISTORY - 1, 3, -1):
                past[i] = past[i - 4]
        self.travel_um = clip(self.travel_um + travel_um, TRAVEL_MAX)
        # turn: the product, plus the drift in its upper 24 bits, modulo 2^32
        drifted = scale(travel_um, self._drift >> 4)
        upper = across_um * (self._angle_per_um >> 8) + drifted
        lower = across_um * (self._angle_per_um & 255) + ((upper & 255) << 8)
        high = (upper >> 8) + (lower >> 16) & 0xFFFF
        lower &= 0xFFFF
        half_high = short(high) >> 1
        half_low = lower >> 1 | (high & 1) << 15
        middle = self.pose[TOP] + half_high + (self.pose[LOW] + half_low >> 16)
        VECTOR[0], VECTOR[1] = travel_um, 0
        turn(middle)
        _add(self.pose, VECTOR[0], VECTOR[1], high, lower)
        moved = self._moved
        _add(moved, VECTOR[0], VECTOR[1], high, lower)
        moved[X] &= 0xFFFFFF
        moved[Y] &= 0xFFFFFF
        past[0] = moved[X] >> 8
        past[1] = moved[Y] >> 8
        past[2] = moved[TOP]
        past[3] = now_us >> 8 & 0xFFFF

    @micropython.native
    def correct(self, seen: bytearray, at: int, angle: int, seen_us: int) -> bool:
        """Take a camera pose of that time; False if unused.

        Its place is at ``seen[at]``, the heading 2^16 a turn.
        """
        past, begin = self._past, 0
        since = short((seen_us >> 8) - past[3])
        while since < 0:
            begin += 4
            if begin == 4 * HISTORY:
                return False  # no longer in the history
            since = short((seen_us >> 8) - past[begin + 3])
        share = 0
        if begin:
            share = (since << 14) // ((past[begin - 1] - past[begin + 3]) & 0xFFFF)
        near = self._find_shift(seen, at, angle, begin, share)
        shift = self._shift
        if self.known:
            if near:
                self._learn_drift(short(shift[TOP]))
                shift[X] = shift[X] + 2 >> 2
                shift[Y] = shift[Y] + 2 >> 2
                # a quarter of the heading, of both halves together
                low = shift[LOW] + 2
                high = short(shift[TOP] + (low >> 16))
                shift[LOW] = (low & 0xFFFF) >> 2 | (high & 3) << 14
                shift[TOP] = high >> 2
            else:
                self._jumps += 1
                if self._jumps < JUMPS_BELIEVED:
                    return False
        _add(self.pose, shift[X], shift[Y], shift[TOP], shift[LOW])
        self._jumps = 0
        self.travel_um = 0
        if not self.fix_recent or 0 < (seen_us - self.fix_us) & TIME < TIME >> 1:
            self.fix_us = seen_us
        self.known = True
        self.fix_recent = True
        return True

    @micropython.native
    def _find_shift(self, seen: bytearray, at: int, angle: int, begin: int, share: int) -> bool:
        """Leave in ``_shift`` the seen pose, moved up to now, minus the pose; True if near."""
        past, shift = self._past, self._shift
        near = True
        for i in range(2):
            since_then = short(past[i] - self._before(i, begin, share)) * 256
            shift[i] = word(get_place(seen, at + 4 * i) - self.pose[i] + since_then)
            if not -JUMP_UM <= shift[i] <= JUMP_UM:
                near = False
        high = angle + past[2] - self._before(2, begin, share) - self.pose[TOP]
        shift[LOW] = -self.pose[LOW] & 0xFFFF
        if self.pose[LOW]:
            high -= 1
        shift[TOP] = high & 0xFFFF
        top = short(high)
        # size of all 32 bits, from their halves
        size = top << 16 - JUMP_SHIFT | shift[LOW] >> JUMP_SHIFT
        if top < 0:
            size = (-top << 16 - JUMP_SHIFT) - (shift[LOW] >> JUMP_SHIFT)
            if shift[LOW] & (1 << JUMP_SHIFT) - 1:
                size -= 1
        return near and size <= JUMP_UM

    @micropython.native
    def _before(self, i: int, begin: int, share: int) -> int:
        """Motion of the wheels up to the camera's picture."""
        before = self._past[begin + i]
        if share:
            before += scale(short(self._past[begin - 4 + i] - before), share)
        return before

    @micropython.native
    def _learn_drift(self, turn: int) -> None:
        drift = self._drift + (scale(self.travel_um, turn) >> 1)
        if -DRIFT_MAX <= drift <= DRIFT_MAX:
            self._drift = drift


@micropython.native
def _add(to: "array[int]", x: int, y: int, high: int, low: int) -> None:
    to[X] = word(to[X] + x)
    to[Y] = word(to[Y] + y)
    low += to[LOW]
    to[LOW] = low & 0xFFFF
    to[TOP] = to[TOP] + high + (low >> 16) & 0xFFFF
