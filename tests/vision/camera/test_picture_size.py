"""The size that a header tells, against the pictures that OpenCV writes and decodes."""

from __future__ import annotations

import struct

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.files.picture_formats import formats
from tests.support.files.png_pictures import chunk, png
from vision.camera.camera import CameraError
from vision.camera.picture_files import read_picture
from vision.camera.picture_size import MOST_PIXELS, oversize, picture_size


@pytest.mark.parametrize("name", [name for name, _ in formats()])
def test_the_size_is_that_of_the_decoded_picture(name: str) -> None:
    data = dict(formats())[name]
    decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded is not None
    height, width = decoded.shape[:2]
    if name in ("turned_6.tif", "turned_8.tif"):  # the decoder turns them
        width, height = height, width
    assert picture_size(data) == (width, height)
    assert oversize(data) == ""


@pytest.mark.parametrize("lossless", [True, False])
@pytest.mark.parametrize("channels", [3, 4])
def test_each_kind_of_webp_tells_its_size(lossless: bool, channels: int) -> None:
    picture = np.full((13, 301, channels), 200, np.uint8)
    picture[4:9, 20:70, -1] = 90
    how = [cv2.IMWRITE_WEBP_QUALITY, 101 if lossless else 80]
    assert picture_size(cv2.imencode(".webp", picture, how)[1].tobytes()) == (301, 13)


def huge() -> dict[str, bytes]:
    """Small files that claim very large pictures."""
    ihdr = struct.pack(">IIBBBBB", 1 << 20, 1 << 10, 8, 3, 0, 0, 0)
    small = png(3, 8)
    found = {"a.png": small[:8] + chunk(b"IHDR", ihdr) + small[33:]}
    seeds = dict(formats())
    jpeg = seeds["grey.jpg"]
    at = jpeg.index(b"\xff\xc0")
    found["a.jpg"] = jpeg[: at + 5] + struct.pack(">HH", 65000, 65000) + jpeg[at + 9 :]
    bmp = seeds["24_bits.bmp"]
    found["a.bmp"] = bmp[:18] + struct.pack("<ii", 30000, -30000) + bmp[26:]
    gif = seeds["colour.gif"]
    found["a.gif"] = gif[:6] + struct.pack("<HH", 60000, 60000) + gif[10:]
    found["a.pgm"] = b"P5\n# a comment\n99999 99999\n255\n\x00"
    found["a.pam"] = seeds["grey.pam"].replace(b"WIDTH 32", b"WIDTH 99999999")
    found["a.pfm"] = b"PF\n99999 99999\n-1.0\n\x00"
    found["a.ras"] = b"\x59\xa6\x6a\x95" + struct.pack(">II", 65000, 65000) + bytes(40)
    found["a.hdr"] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65000 +X 65000\n\x00"
    if "grey.jp2" in seeds:
        jp2 = seeds["grey.jp2"]
        at = jp2.index(b"\xff\x4f\xff\x51") + 8
        found["a.jp2"] = jp2[:at] + struct.pack(">II", 65000, 65000) + jp2[at + 8 :]
    if "colour.avif" in seeds:
        avif = seeds["colour.avif"]
        at = avif.index(b"ispe") + 8
        found["a.avif"] = avif[:at] + struct.pack(">II", 65000, 65000) + avif[at + 8 :]
    return found


@pytest.mark.parametrize("name", sorted(huge()))
def test_a_small_file_that_claims_a_huge_picture_is_refused_before_it_is_decoded(
    name: str, tmp_path: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / name  # type: ignore[operator]
    path.write_bytes(huge()[name])
    monkeypatch.setattr(cv2, "imdecode", lambda *_: pytest.fail("it was decoded"))
    with pytest.raises(CameraError, match=f"must be at most {MOST_PIXELS}"):
        read_picture(path)


def test_a_part_longer_than_its_file_is_refused_before_room_is_made_for_it() -> None:
    small = png(3, 8)
    harmed = small[:33] + b"\xff\xff\x00\x8b" + small[37:]
    assert "a part of 4294901899 bytes in a file of" in oversize(harmed)
    assert oversize(small[:-5]) == ""


@given(st.sampled_from([data for _, data in formats()]), st.binary(max_size=40), st.integers(0, 60))
def test_any_bytes_have_a_size_or_none(data: bytes, harm: bytes, at: int) -> None:
    harmed = data[:at] + harm + data[at + len(harm) :]
    for cut in (harmed, harmed[:at], harmed[:30]):
        size = picture_size(cut)
        assert size is None or (size[0] >= 0 and size[1] >= 0)
