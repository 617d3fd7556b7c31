"""Pololu 3pi+ 2040, over its library pololu_3pi_2040_robot; the line is its USB port.

Copy this file as main.py beside the folder clearway: see docs/micropython.md. For Turtle (75:1) and
Hyper (15:1) change the two numbers below, the Standard Edition's (30:1).
"""

import gc
import os
import time

from clearway.lines import UsbLine
from clearway.program import Program
from clearway.settings import Settings
from clearway.start import bootsel_held, may_start
from clearway.wheels import Duty, Odometer
from pololu_3pi_2040_robot import robot

FULL_SPEED_MM_S = 1500  # a wheel at full power
NM_PER_COUNT = 280_562  # wheels of 32 mm, 358.3 counts a turn
SETTINGS = Settings(track_um=84_500, max_speed_mm_s=300)
MOST = 6000


class Board:
    def __init__(self):
        self._motors, self._encoders = robot.Motors(), robot.Encoders()
        self._stop = robot.ButtonB()
        self._counts = self._encoders.get_counts()
        self._duty, self._odometer = Duty(FULL_SPEED_MM_S, MOST), Odometer(NM_PER_COUNT)
        line = UsbLine()
        self.read, self.can_write, self.write = line.read, line.can_write, line.write

    def travel_um(self, side):
        if side == 0:
            self._counts = self._encoders.get_counts()
        return self._odometer.travel_um(side, self._counts[side])

    def drive(self, left, right, powered):
        left, right = (left, right) if powered else (0, 0)
        self._motors.set_speeds(self._duty.of(0, left), self._duty.of(1, right))

    def stop_pressed(self):
        return self._stop.is_pressed()

    def idle(self, powered):
        if not powered:
            gc.collect()  # the library allocates; while driving the heap lasts for minutes


if __name__ == "__main__" and may_start(bootsel_held):
    Program(Board(), SETTINGS, time.ticks_us, int.from_bytes(os.urandom(4), "little")).run()
