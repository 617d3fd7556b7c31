"""Stands in for ``machine``: an H bridge, two encoders, a button, whatever their pins are."""

import world

MM_PER_EDGE = 0.5
PICO_B, ESP32_B = {11: 0, 13: 1}, {33: 0, 19: 1}
"""Which wheel's output B is on a pin."""
_pwms = []
_encoders = []  # A and B of the left wheel, then of the right one


class Pin:
    IN, OUT, PULL_UP, IRQ_RISING, IRQ_FALLING = 0, 1, 2, 1, 2

    def __init__(self, number, mode=None, pull=None, value=None):
        self.number, self.mode, self.level = number, mode, value or 0
        self.pull = pull
        if mode == Pin.OUT:
            _find_back(self)

    def irq(self, handler, trigger, hard=False):
        wheel = Encoder(len(_encoders), self, handler)
        _encoders.append(wheel)
        world.listeners.append(wheel.turned)

    def value(self, level=None):
        if level is not None:
            self.level = int(level)
            return None
        for encoder in _encoders:
            if self is encoder.a:
                return encoder.phase in (1, 2)
        if self.number == 0:  # the boot button
            return int(not world.held_at_boot)
        side = (PICO_B if _encoders[0].a.number == 10 else ESP32_B).get(self.number)
        return _encoders[side].phase in (2, 3) if side is not None else not world.pressed


class Encoder:
    """A leads B when the wheel turns forwards; an interrupt at each edge of A."""

    def __init__(self, side, a, handler):
        self.side, self.a, self.handler = side, a, handler
        self.phase, self.at_mm = 0, 0.0

    def turned(self, side):
        while side == self.side and abs(world.travelled_mm[side] - self.at_mm) >= MM_PER_EDGE / 2:
            step = 1 if world.travelled_mm[side] > self.at_mm else -1
            before = self.phase in (1, 2)
            self.phase = (self.phase + step) % 4
            self.at_mm += step * MM_PER_EDGE / 2
            if before != (self.phase in (1, 2)):
                self.handler(self.a)


class PWM:
    def __init__(self, pin, freq, duty_u16):
        assert freq >= 15_000, "audible"
        self.side, self.back = len(_pwms), None
        _pwms.append(self)
        self.duty_u16(duty_u16)

    def duty_u16(self, duty):
        assert 0 <= duty <= 65535
        sign = -1.0 if self.back is not None and self.back.level else 1.0
        world.speeds[self.side] = sign * duty / 65535 * world.FULL_MM_S["pwm"]


def _find_back(pin):
    """The first output pins are the wheels' directions, in their order."""
    if all(pwm.back is not pin for pwm in _pwms):
        next(pwm for pwm in _pwms if pwm.back is None).back = pin


class UART:
    def __init__(self, number, baud, tx, rx, txbuf, rxbuf=0):
        assert baud == 115_200
        assert txbuf >= 128

    def any(self):
        return 0


class WDT:
    def __init__(self, timeout):
        assert timeout <= 1_000

    def feed(self):
        pass
