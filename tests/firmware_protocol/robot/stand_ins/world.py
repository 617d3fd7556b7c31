"""The wheels behind every stand-in: what drives them, and what turns the encoders."""

FULL_MM_S = {"pwm": 800.0, "xrp": 400.0, "alvik": 124.0, "3pi": 1500.0}
speeds = [0.0, 0.0]
travelled_mm = [0.0, 0.0]
pressed = False
held_at_boot = False
now_us = 0
listeners = []


def wheels():
    """The wheels' speeds, left and right, in mm/s."""
    return speeds[0], speeds[1]


def turn(left_mm, right_mm):
    """Somebody turns the wheels."""
    for side, travel in ((0, left_mm), (1, right_mm)):
        travelled_mm[side] += travel
        for listener in listeners:
            listener(side)


def press():
    """Somebody presses the stop button."""
    global pressed
    pressed = True


def pass_time():
    """20 ms pass."""
    global now_us
    now_us += 20_000
