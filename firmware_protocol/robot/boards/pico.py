"""Raspberry Pi Pico with an H bridge (PWM and direction a wheel) and two quadrature encoders.

Copy this file as main.py beside the folder clearway: see docs/micropython.md.
"""

import os
import time
from array import array

from clearway.lines import UartLine
from clearway.program import Program
from clearway.settings import Settings
from clearway.start import bootsel_held, may_start
from clearway.wheels import Duty, Odometer
from machine import PWM, UART, WDT, Pin

FULL_SPEED_MM_S = 800  # a wheel at full PWM
NM_PER_EDGE = 500_000  # travel between two edges of encoder output A
SETTINGS = Settings(track_um=120_000, max_speed_mm_s=500)


class Board:
    def __init__(self):
        self._pwm = (PWM(Pin(6), freq=20_000, duty_u16=0), PWM(Pin(8), freq=20_000, duty_u16=0))
        self._back = (Pin(7, Pin.OUT, value=0), Pin(9, Pin.OUT, value=0))
        self._b = (Pin(11, Pin.IN, Pin.PULL_UP), Pin(13, Pin.IN, Pin.PULL_UP))
        self._counts = array("i", (0, 0))
        self._duty, self._odometer = Duty(FULL_SPEED_MM_S, 65535 >> 4), Odometer(NM_PER_EDGE)
        for pin, handler in ((10, self._left_edge), (12, self._right_edge)):
            Pin(pin, Pin.IN, Pin.PULL_UP).irq(handler, Pin.IRQ_RISING | Pin.IRQ_FALLING, hard=True)
        self._stop = Pin(14, Pin.IN, Pin.PULL_UP)  # a button to ground
        line = UartLine(UART(0, 115_200, tx=Pin(0), rx=Pin(1), txbuf=256, rxbuf=512))
        self.read, self.can_write, self.write = line.read, line.can_write, line.write
        self._watchdog = WDT(timeout=250)

    def _left_edge(self, a):
        self._counts[0] += 1 if a.value() != self._b[0].value() else -1

    def _right_edge(self, a):
        self._counts[1] += 1 if a.value() != self._b[1].value() else -1

    def travel_um(self, side):
        return self._odometer.travel_um(side, self._counts[side])

    def drive(self, left, right, powered):
        for side in (0, 1):
            duty = self._duty.of(side, left if side == 0 else right) if powered else 0
            self._back[side].value(duty < 0)
            self._pwm[side].duty_u16(abs(duty) << 4)

    def stop_pressed(self):
        return not self._stop.value()

    def idle(self, powered):
        self._watchdog.feed()


if __name__ == "__main__" and may_start(bootsel_held):
    Program(Board(), SETTINGS, time.ticks_us, int.from_bytes(os.urandom(4), "little")).run()
