"""Check of an earlier picture's level on a later picture of the same scene."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from planner.scene import Binarisation
from vision.binarise.grey_picture import GreyPicture, as_array, as_grey, scaled_threshold
from vision.binarise.regions.edge_evidence import leaves_out


def level_leaves_out(image: NDArray[Any], how: Binarisation) -> bool:
    """True if ``image`` (h, w) shows clear edges that the level of ``how`` does not separate."""
    image = as_array(image)
    grey, level = as_grey(image), scaled_threshold(how.threshold, image)
    if how.polarity == "light":
        grey = cv2.bitwise_not(grey) if grey.dtype == np.uint8 else 255 - grey
        level = 255.0 - level
        return leaves_out(GreyPicture(grey), level, "light")
    return leaves_out(GreyPicture(grey), level, "dark")
