"""Stands in for XRPLib's motors: 1 is the left one, 2 the right one."""

import world


class EncodedMotor:
    def __init__(self, side):
        self._side = side

    @classmethod
    def get_default_encoded_motor(cls, index):
        return cls(index - 1)

    def set_effort(self, effort):
        assert -1.0 <= effort <= 1.0
        world.speeds[self._side] = effort * world.FULL_MM_S["xrp"]

    def get_position_counts(self):
        return int(world.travelled_mm[self._side] / (3.14159265 * 60.0) * 585)
