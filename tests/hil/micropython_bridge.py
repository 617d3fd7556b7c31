"""The MicroPython robot for a program that steps it, in lockstep with that program's time.

    micropython micropython_bridge.py FOLDER_OF_CLEARWAY

Speaks on stdin and stdout as ``tests.support.robots.emulated_processor`` says; its wheels are PWM
numbers and encoder steps of 250 um. Every round of the program runs with the heap locked, so that
one that allocates ends it. It takes no longer than the time asked for: how long a round would take
on a board is measured elsewhere.
"""

import struct
import sys

ROUND_US = 500
BYTE_US = 87
CYCLES_US = 16
FULL_SPEED_MM_S = 800
TICK_NM = 250000


class Bench:
    """A board whose clock, line and wheels are the asking program's."""

    def __init__(self, wheels):  # type: ignore[no-untyped-def]
        self.now_us = 0
        self.off_us = 0
        self.counts = [0, 0]
        self.pwm = [0, 0]
        self.powered = False
        self._odometer = wheels.Odometer(TICK_NM)
        self._duty = wheels.Duty(FULL_SPEED_MM_S, 255)
        self.waiting = bytearray(4096)
        self.first = 0
        self.last = 0
        self._next_us = 0
        self.said = bytearray(4096)
        self.said_count = 0
        self._busy_us = 0

    def read(self, buffer):  # type: ignore[no-untyped-def]
        count = 0
        while count < len(buffer) and self.first < self.last and self._next_us <= self.now_us:
            buffer[count] = self.waiting[self.first]
            count += 1
            self.first += 1
            self._next_us = max(self._next_us, self.now_us - ROUND_US) + BYTE_US
        return count

    def can_write(self):  # type: ignore[no-untyped-def]
        return self.now_us >= self._busy_us

    def write(self, view):  # type: ignore[no-untyped-def]
        for i in range(len(view)):
            self.said[self.said_count] = view[i]
            self.said_count += 1
        self._busy_us = self.now_us + BYTE_US * len(view)

    def travel_um(self, side):  # type: ignore[no-untyped-def]
        return self._odometer.travel_um(side, self.counts[side])

    def drive(self, left, right, powered):  # type: ignore[no-untyped-def]
        if self.powered and not powered:
            self.off_us = self.now_us
        self.powered = powered
        self.pwm[0] = self._duty.of(0, left) if powered else 0
        self.pwm[1] = self._duty.of(1, right) if powered else 0

    def stop_pressed(self):  # type: ignore[no-untyped-def]
        return False


def main():  # type: ignore[no-untyped-def]
    """Serve stdin."""
    import os

    import micropython  # type: ignore[import-not-found]

    from clearway import program, settings, wheels  # type: ignore[import-not-found]

    ask, say = sys.stdin.buffer, sys.stdout.buffer
    bench = Bench(wheels)

    def start():  # type: ignore[no-untyped-def]
        boot_id = int.from_bytes(os.urandom(4), "little")
        return program.Program(bench, settings.Settings(), lambda: bench.now_us, boot_id)

    running = start()
    while True:
        head = ask.read(11)
        if not head or len(head) < 11:
            return
        us, left, right, flags, count = struct.unpack("<IhhBH", head)
        kept = bench.last - bench.first
        bench.waiting[:kept] = bench.waiting[bench.first : bench.last]
        bench.waiting[kept : kept + count] = ask.read(count) if count else b""
        bench.first, bench.last = 0, kept + count
        if flags & 1:
            bench.drive(0, 0, False)
            running = start()
        bench.counts[0] += left
        bench.counts[1] += right
        bench.said_count = 0
        end_us = bench.now_us + us
        micropython.heap_lock()
        while bench.now_us < end_us:
            bench.now_us = min(bench.now_us + ROUND_US, end_us)
            running.round()
        micropython.heap_unlock()
        state = bench.powered | (bench.pwm[0] < 0) << 1 | (bench.pwm[1] < 0) << 2
        off, now = (time_us * CYCLES_US & 0xFFFFFFFF for time_us in (bench.off_us, bench.now_us))
        pwm = (abs(bench.pwm[0]), abs(bench.pwm[1]))
        say.write(struct.pack("<BBBIIH", pwm[0], pwm[1], state, off, now, bench.said_count))
        say.write(bytes(bench.said[: bench.said_count]))
        if hasattr(say, "flush"):
            say.flush()


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    main()
