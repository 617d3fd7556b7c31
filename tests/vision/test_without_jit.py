"""Global Vision's kernels are their own reference: as plain Python they answer alike."""

from __future__ import annotations

from tests.support.without_jit import answers_differ, printed_by

DIGEST = """
import hashlib, warnings
import numpy as np
# indices that count backwards wrap around on purpose
warnings.filterwarnings("ignore", "overflow encountered in scalar add", RuntimeWarning)
from vision.binarise.binarise import binarise
from vision.borders.contours import follow_borders
whole = hashlib.sha256()
rng = np.random.default_rng(5)
for sigma in (0.0, 6.0, 20.0):
    picture = np.full((40, 52), 200.0)
    picture[8:30, 10:35] = 40.0
    picture += rng.normal(0.0, sigma, picture.shape)
    binary = binarise(np.clip(picture, 0, 255).astype(np.uint8))
    whole.update(binary.mask.tobytes() + f"{binary.level:.9g} {binary.noise:.9g}".encode())
for share in (0.1, 0.5, 0.9):
    noise = (rng.random((23, 31)) > share).astype(np.uint8) * 255
    borders = follow_borders(binarise(noise, threshold=128).mask)
    for a in (borders.x, borders.y, borders.direction, borders.starts, borders.area):
        whole.update(np.ascontiguousarray(a, dtype=np.int64).tobytes())
print(len(borders.starts), whole.hexdigest())
"""


EXTRACTED = """
import dataclasses, json, warnings
import cv2
import numpy as np
import vision
# indices that count backwards wrap around on purpose
warnings.filterwarnings("ignore", "overflow encountered in scalar add", RuntimeWarning)
# wider than one block of the dots' kernel, with more than 255 pixels that noise leaves out
width, height = 132, 44
x, y = np.meshgrid(np.arange(width), np.arange(height))
picture = np.full((height, width), 200.0)
picture[11:29, 16:44] = 60.0
picture[(x - 92) ** 2 + (y - 24) ** 2 < 10**2] = 60.0
picture[14:16, 66:68] = 20.0
picture *= np.linspace(0.6, 1.1, width)
picture = cv2.GaussianBlur(picture, (0, 0), 0.7)
picture += np.random.default_rng(5).normal(0.0, 14.0, picture.shape)
scene = vision.extract(np.clip(picture, 0, 255).astype(np.uint8))
print(json.dumps({
    "objects": [dataclasses.asdict(thing) for thing in scene.objects],
    "binarisation": dataclasses.asdict(scene.binarisation),
    "border_pixels": scene.border_pixels,
    "remarks": scene.remarks,
}))
"""


def test_mask_and_borders_are_the_same_without_the_compiler() -> None:
    compiled, plain = (printed_by(DIGEST, compiled=way) for way in (True, False))
    assert compiled == plain
    assert int(compiled.split()[0]) > 3


def test_a_noisy_picture_in_uneven_light_is_the_same_without_the_compiler() -> None:
    assert answers_differ(EXTRACTED) == []
