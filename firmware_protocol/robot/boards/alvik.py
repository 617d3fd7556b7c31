"""Arduino Alvik (Nano ESP32), over its library arduino_alvik; the line is its USB port.

Copy this file as main.py beside the folder clearway: see docs/micropython.md.
"""

import gc
import os
import time

from arduino_alvik import ArduinoAlvik
from clearway.lines import UsbLine
from clearway.program import Program
from clearway.settings import Settings
from clearway.start import boot_pin_held, may_start
from clearway.wheels import Duty, Odometer

FULL_RPM = 70
FULL_SPEED_MM_S = 124  # with wheels of 34 mm
NM_PER_TENTH = 29_671  # travel for a tenth of a degree
SETTINGS = Settings(track_um=89_000, max_speed_mm_s=100, max_turn_mrad_s=1800)
ORDER_US = 20_000  # its processors share a line


class Board:
    def __init__(self):
        self._alvik = ArduinoAlvik()
        self._alvik.begin()
        self._wheels = (self._alvik.left_wheel, self._alvik.right_wheel)
        self._duty, self._odometer = Duty(FULL_SPEED_MM_S, FULL_RPM), Odometer(NM_PER_TENTH)
        self._ordered_us, self._powered = 0, False
        line = UsbLine()
        self.read, self.can_write, self.write = line.read, line.can_write, line.write

    def travel_um(self, side):
        return self._odometer.travel_um(side, int(self._wheels[side].get_position() * 10))

    def drive(self, left, right, powered):
        now_us = time.ticks_us()
        stops = self._powered and not powered
        if stops or time.ticks_diff(now_us, self._ordered_us) >= ORDER_US:
            self._ordered_us, self._powered = now_us, powered
            left, right = (left, right) if powered else (0, 0)
            self._alvik.set_wheels_speed(self._duty.of(0, left), self._duty.of(1, right))

    def stop_pressed(self):
        return self._alvik.get_touch_cancel()

    def idle(self, powered):
        if not powered:
            gc.collect()  # the library allocates; while driving the heap lasts for minutes


if __name__ == "__main__" and may_start(boot_pin_held):
    Program(Board(), SETTINGS, time.ticks_us, int.from_bytes(os.urandom(4), "little")).run()
