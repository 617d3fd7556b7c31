"""The robots' colours are told apart by everybody, and carry white writing; zones' are read."""

from itertools import combinations
from typing import get_args

import numpy as np
import pytest

from navigation.dashboard.messages.palette import ROBOTS, stylesheet
from navigation.draw.shapes import FLOOR
from navigation.draw.zones import COLOURS as ZONES
from planner.zones.zone import ZoneKind
from tests.navigation.dashboard.contrast import contrast

TOLD_APART = 28.0
"""CIE 1976; a just noticeable difference is 2.3."""
READABLE = 4.5
"""WCAG 2.2, 1.4.3."""
# Machado, Oliveira and Fernandes (2009): what is seen without one kind of cones, in linear light
SIGHTS = {
    "all cones": np.eye(3),
    "no long": [
        [0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no medium": [
        [0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "no short": [
        [1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}  # fmt: skip
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
     [0.0193339, 0.1191920, 0.9503041]]
)  # fmt: skip
WHITE = np.array([0.95047, 1.0, 1.08883])


def lab(colour: tuple[int, int, int], sight: object) -> np.ndarray:
    share = np.array(colour) / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    t = XYZ @ np.clip(np.array(sight) @ linear, 0.0, 1.0) / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * (29 / 6) ** 2 / 3 + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("sight", list(SIGHTS))
def test_any_two_robots_colours_are_told_apart(sight: str) -> None:
    seen = [lab(colour, SIGHTS[sight]) for colour in ROBOTS]
    assert min(float(np.linalg.norm(a - b)) for a, b in combinations(seen, 2)) >= TOLD_APART


def test_white_numbers_are_readable_on_every_robots_colour() -> None:
    assert min(contrast(colour, (255, 255, 255)) for colour in ROBOTS) >= READABLE
    assert all(f"--robot-{number}:" in stylesheet() for number in range(len(ROBOTS)))


def test_names_of_zones_are_readable_on_the_floor_for_every_kind() -> None:
    assert set(ZONES) == set(get_args(ZoneKind))
    assert min(contrast(colour, FLOOR) for colour in ZONES.values()) >= READABLE
    assert all(f"--zone-{kind.replace('_', '-')}:" in stylesheet() for kind in ZONES)
