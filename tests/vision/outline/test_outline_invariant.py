"""No outline far from its border, no border far from its outline: drawings, photographs, noise.

Rules and units
- The judge is ``tests.support.drawn.outline_judge``, which knows nothing of the fits; pixels.
- ``vision.outline.check.stray_kernels`` holds it for every outline that is given out.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests.support.drawn.outline_judge import FEW_PX, failures, mask_of
from tests.support.drawn.outline_pictures import FAMILIES, LOOKS, Look, Picture, shown
from vision import PictureError, extract
from vision.binarise import Polarity

POLARITIES = st.sampled_from(["dark", "light"])
FEW = settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
SEEDS = st.integers(0, 2**32 - 1)
IN_NOISE_PX = 6.0
"""What an outline and its border may be apart in noise: the light crosses the half level up to
2.5 px beside a crack (``WANDER`` and half a pixel), so up to 3.5 px on a diagonal border, and
points of an outline that are 2 px apart lie within 2 px of crossings, all others within 2.3."""


def hold(picture: Picture, polarity: Polarity, limit_px: float = FEW_PX) -> None:
    """Fail where a record and its border do not stand for each other."""
    try:
        scene = extract(picture, polarity=polarity)
    except PictureError:
        # no free pixel is left, and nothing to fit
        return
    assert failures(mask_of(picture, polarity), scene, limit_px) == []


@FEW
@given(st.sampled_from(sorted(FAMILIES)), st.sampled_from(LOOKS), SEEDS)
def test_outlines_of_drawings_lie_on_their_borders(family: str, look: Look, seed: int) -> None:
    rng = np.random.default_rng(seed)
    share = FAMILIES[family](rng)
    picture = shown(share, look, rng)
    hold(picture, look.polarity)


@FEW
@given(
    st.sampled_from(["calibration/left01.jpg", "calibration/left12.jpg", "shapes/pic1.png",
                     "shapes/silhouette_3.png", "markers/choriginal.jpg"]),
    POLARITIES,
    st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.3, 1.0)),
    st.floats(0.0, 360.0),
)  # fmt: skip
def test_outlines_of_photographs_lie_on_their_borders(
    real_data: Path, name: str, polarity: Polarity, crop: tuple[float, float, float], turn: float
) -> None:
    """A part of a photograph, turned: its borders meet the rows of pixels at any angle."""
    picture = cv2.imread(str(real_data / name), cv2.IMREAD_GRAYSCALE)
    h, w = picture.shape
    side = int(crop[2] * min(h, w, 400))
    left, top = int(crop[0] * (w - side)), int(crop[1] * (h - side))
    part = picture[top : top + side, left : left + side]
    about = cv2.getRotationMatrix2D((side / 2, side / 2), turn, 1.0)
    hold(cv2.warpAffine(part, about, (side, side), borderMode=cv2.BORDER_REFLECT_101), polarity)


@FEW
@given(SEEDS, st.floats(1.0, 8.0), st.floats(20.0, 100.0), st.floats(0.0, 15.0), POLARITIES)
@example(319, 2.0, 30.0, 2.0, "light")
def test_outlines_of_noise_lie_on_their_borders(
    seed: int, grain_px: float, contrast: float, noise: float, polarity: Polarity
) -> None:
    """Clouds of noise: borders without a line or an arc, of every size."""
    rng = np.random.default_rng(seed)
    clouds = cv2.GaussianBlur(rng.normal(size=(160, 200)), (0, 0), grain_px)
    grey = 128.0 + contrast * clouds / clouds.std() + rng.normal(0.0, noise, clouds.shape)
    hold(np.clip(np.rint(grey), 0, 255).astype(np.uint8), polarity, IN_NOISE_PX)


@pytest.mark.parametrize("value", [0, 128, 255])
def test_a_picture_of_one_grey_has_no_outline_or_is_refused(value: int) -> None:
    hold(np.full((60, 80), value, np.uint8), "dark")
