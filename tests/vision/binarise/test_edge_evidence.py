"""Whether a level follows edges: yes in plain pictures, at once; no along a shadow's rim."""

from __future__ import annotations

import numpy as np
import pytest

from planner.scene import CircleRecord
from tests.support.drawn.render import draw
from vision.binarise.grey_classes import classes_of
from vision.binarise.grey_picture import GreyPicture
from vision.binarise.regions.edge_evidence import EdgeEvidence, follows_edges

SIZE = (320, 240)
DISCS = [CircleRecord((60.0 + 100 * i, 70.0 + 90 * j), 25.0) for i in range(3) for j in range(2)]


@pytest.mark.parametrize("dark", [0.0, 40.0, 150.0])
@pytest.mark.parametrize("blur", [0.0, 0.7, 1.5])
@pytest.mark.parametrize("noise", [0.0, 5.0, 10.0])
def test_the_level_of_a_plain_picture_follows_edges(dark: float, blur: float, noise: float) -> None:
    rng = np.random.default_rng(1)
    picture = draw(DISCS, SIZE, dark=dark, light=250.0, blur=blur, noise=noise, rng=rng)
    grey_picture = GreyPicture(picture)
    classes = classes_of(grey_picture)
    assert classes is not None
    assert follows_edges(grey_picture, classes)


def test_the_level_between_a_shadow_and_the_light_does_not() -> None:
    x = np.arange(SIZE[0])[None].repeat(SIZE[1], axis=0)
    picture = draw(DISCS, SIZE, lit=1.0 - 0.4 / (1.0 + np.exp(-(x - 200) / 10)))
    grey_picture = GreyPicture(picture)
    classes = classes_of(grey_picture)
    assert classes is not None
    assert classes.dark > 100.0
    assert not follows_edges(grey_picture, classes)
    best, _ = EdgeEvidence(grey_picture, "dark").best_level(grey_picture.counts, classes)
    assert best is not None
    assert 45.0 < best.level < 129.0


def test_nothing_speaks_for_any_level_of_an_empty_ramp() -> None:
    ramp = np.linspace(60.0, 220.0, SIZE[0])[None].repeat(SIZE[1], axis=0).astype(np.uint8)
    grey_picture = GreyPicture(ramp)
    assert EdgeEvidence(grey_picture, "dark").best_level(grey_picture.counts, None)[0] is None
