"""Stands in for the Alvik's library."""

import world


class Wheel:
    def __init__(self, side):
        self._side = side

    def get_position(self):
        return world.travelled_mm[self._side] / (3.14159265 * 34.0) * 360.0


class ArduinoAlvik:
    def __init__(self):
        self.left_wheel, self.right_wheel = Wheel(0), Wheel(1)

    def begin(self):
        return 0

    def set_wheels_speed(self, left, right, unit="rpm"):
        for side, rpm in ((0, left), (1, right)):
            assert -70 <= rpm <= 70
            world.speeds[side] = rpm / 70 * world.FULL_MM_S["alvik"]

    def get_touch_cancel(self):
        return world.pressed
