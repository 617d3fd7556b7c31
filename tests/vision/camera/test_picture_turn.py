"""Pictures turned by their EXIF orientation: as OpenCV turns them, and never for a camera."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.files.picture_formats import formats, turned_jpeg
from tests.support.files.png_pictures import chunk, exif, png
from tests.support.files.small_picture import grey_picture
from vision.camera.picture_files import read_picture
from vision.camera.picture_turn import orientation, turned

FORMATS = dict(formats())


@pytest.mark.parametrize("told", range(1, 9))
def test_a_turned_picture_is_the_one_that_opencv_turns(told: int) -> None:
    data = np.frombuffer(turned_jpeg(told), np.uint8)
    as_shown = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    as_stored = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    assert orientation(turned_jpeg(told)) == told
    np.testing.assert_array_equal(turned(as_stored, told), as_shown)
    colour = np.dstack([as_stored] * 3)
    np.testing.assert_array_equal(turned(colour, told)[:, :, 1], as_shown)


def test_png_and_webp_tell_their_orientation_too() -> None:
    assert orientation(FORMATS["turned.png"]) == 6
    simple = FORMATS["lossy.webp"]
    for head in (b"", b"Exif\0\0"):
        body = head + exif(8)
        told = b"EXIF" + len(body).to_bytes(4, "little") + body + b"\0" * (len(body) % 2)
        assert orientation(simple + told) == 8


def test_a_picture_that_tells_nothing_or_nonsense_is_as_stored() -> None:
    for name, data in FORMATS.items():
        if not name.startswith("turned"):
            assert orientation(data) == 1, name
    for told in (0, 9, 65535):
        assert orientation(turned_jpeg(told)) == 1
    big = b"MM\0*" + bytes((0, 0, 0, 8, 0, 1, 0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, 3, 0, 0, 0, 0, 0, 0))
    assert orientation(png(0, 8, more=chunk(b"eXIf", big))) == 3


@pytest.mark.parametrize("name", ["turned_3.jpg", "turned_6.jpg", "turned.png"])
def test_a_camera_gives_the_pixels_of_its_sensor(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(FORMATS[name])
    read = read_picture(path)
    assert read.shape == (24, 32)
    np.testing.assert_allclose(read, grey_picture(), atol=8)


@given(st.sampled_from(sorted(FORMATS)), st.binary(max_size=40), st.integers(0, 90))
def test_any_bytes_have_an_orientation(name: str, harm: bytes, at: int) -> None:
    data = FORMATS[name]
    harmed = data[:at] + harm + data[at + len(harm) :]
    for cut in (harmed, harmed[:at], harmed[:30]):
        assert 1 <= orientation(cut) <= 8
