"""The XRP robot (SparkFun, Open-STEM), over its library XRPLib; the line is its USB port.

Copy this file as main.py beside the folder clearway: see docs/micropython.md.
"""

import gc
import os
import time

from clearway.lines import UsbLine
from clearway.program import Program
from clearway.settings import Settings
from clearway.start import bootsel_held, may_start
from clearway.wheels import Duty, Odometer
from XRPLib.board import Board as XRPBoard
from XRPLib.encoded_motor import EncodedMotor

FULL_SPEED_MM_S = 400  # a wheel at full effort
NM_PER_COUNT = 322_215  # wheels of 60 mm, 585 counts a turn
SETTINGS = Settings(track_um=155_000, max_speed_mm_s=250, max_turn_mrad_s=2000)
STEPS = 1000
EFFORTS = tuple(step / STEPS for step in range(-STEPS, STEPS + 1))  # made once: floats allocate


class Board:
    def __init__(self):
        motor = EncodedMotor.get_default_encoded_motor
        self._motors = (motor(1), motor(2))
        self._button = XRPBoard.get_default_board()
        self._duty, self._odometer = Duty(FULL_SPEED_MM_S, STEPS), Odometer(NM_PER_COUNT)
        line = UsbLine()
        self.read, self.can_write, self.write = line.read, line.can_write, line.write

    def travel_um(self, side):
        return self._odometer.travel_um(side, self._motors[side].get_position_counts())

    def drive(self, left, right, powered):
        for side in (0, 1):
            duty = self._duty.of(side, left if side == 0 else right) if powered else 0
            self._motors[side].set_effort(EFFORTS[duty + STEPS])

    def stop_pressed(self):
        return self._button.is_button_pressed()

    def idle(self, powered):
        if not powered:
            gc.collect()  # XRPLib allocates; while driving the heap lasts for minutes


if __name__ == "__main__" and may_start(bootsel_held):
    Program(Board(), SETTINGS, time.ticks_us, int.from_bytes(os.urandom(4), "little")).run()
