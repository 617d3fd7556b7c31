"""Stands in for the library of the 3pi+ 2040, Standard Edition."""

import world


class Motors:
    def set_speeds(self, left, right):
        for side, speed in ((0, left), (1, right)):
            assert -6000 <= speed <= 6000
            world.speeds[side] = speed / 6000 * world.FULL_MM_S["3pi"]


class Encoders:
    def get_counts(self):
        return [int(travel / (3.14159265 * 32.0) * 358.3) for travel in world.travelled_mm]


class ButtonB:
    def is_pressed(self):
        return world.pressed
