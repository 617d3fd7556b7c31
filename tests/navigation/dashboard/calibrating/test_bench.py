"""A lens calibrated while a run is at rest: found and saved, cancelled, refused, or failed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from navigation.config import Config
from navigation.dashboard.calibrating.bench import LENT, Bench, board_of
from navigation.dashboard.visits import RefusedError
from tests.support.runs.held_board import CHARUCO, VirtualTime, small_config
from tests.support.waiting import wait_until
from vision.calibrate.lens import Lens
from vision.calibration.calibration import Calibration
from vision.camera.camera import Frame, Image

CALIBRATION = Calibration.from_scale(0.002, (640, 480))
TYPED = {"kind": "charuco", "squares": "8x6", "square_mm": "100", "marker_mm": "75",
         "dictionary": "DICT_5X5_100"}  # fmt: skip


class Run:
    """Lends its camera; a simulated one shows a board by itself, and needs no frame."""

    lent: str | None = None
    frame: Frame | None = None


class Saved:
    """Keeps what it is given; fails where it has a reason."""

    def __init__(self, why: str = "") -> None:
        self.lenses: list[Lens] = []
        self._why = why

    def __call__(self, lens: Lens, picture: Image | None) -> str:
        if self._why:
            raise ValueError(self._why)
        self.lenses.append(lens)
        return "saved"


def bench_of(
    run: Run,
    save: Callable[[Lens, Image | None], str],
    config: Config | None = None,
    calibration: Calibration = CALIBRATION,
) -> Bench:
    time = VirtualTime()
    found_soon = config or small_config(noise_grey=0.0)
    return Bench(run, found_soon, calibration, save, time.clock, time.wait)


def test_a_lens_is_found_while_the_robot_holds_and_saved_when_somebody_says_so() -> None:
    run, saved = Run(), Saved()
    bench = bench_of(run, saved)
    bench.start(CHARUCO)
    assert run.lent == LENT
    assert wait_until(lambda: bench.facts()["state"] is not None, 60.0)
    assert "hold the board" in bench.facts()["state"]["sentence"]
    assert bench.picture("")[:2] == b"\xff\xd8"  # type: ignore[index]  # a JPEG
    with pytest.raises(RefusedError, match="already"):
        bench.start(CHARUCO)
    with pytest.raises(RefusedError, match="no lens was found yet"):
        bench.save()
    assert wait_until(lambda: bench.facts()["phase"] == "found", 240.0), bench.facts()["said"]
    assert saved.lenses == []
    assert run.lent == LENT
    assert "put the board away, then save" in bench.facts()["said"]
    assert bench.save() == "saved"
    assert run.lent is None
    (lens,) = saved.lenses
    assert lens.camera_matrix[0, 0] == pytest.approx(617.0, rel=0.01)
    assert lens.model == "brown"


def test_a_cancel_gives_the_camera_back_and_writes_nothing() -> None:
    run, saved = Run(), Saved()
    bench = bench_of(run, saved)
    bench.start(CHARUCO)
    assert bench.cancel() == "the calibration is cancelled"
    assert run.lent is None
    facts = bench.facts()
    assert (facts["phase"], facts["said"]) == ("idle", "cancelled: nothing was written")
    bench.close()
    assert bench.cancel() == "no calibration is under way"
    bench.start(CHARUCO)  # and may begin again
    bench.close()
    assert saved.lenses == []


def test_a_camera_that_gives_no_picture_is_given_back_with_a_sentence() -> None:
    config = small_config()
    camera = config.camera.model_copy(update={"source": "/dev/video0"})
    run = Run()
    bench = bench_of(run, Saved(), config.model_copy(update={"camera": camera}))
    bench.start(CHARUCO)
    assert wait_until(lambda: bench.facts()["phase"] == "idle", 60.0)
    assert "no picture within 5 s: nothing was written" in bench.facts()["said"]
    assert run.lent is None


def test_what_cannot_be_saved_leaves_the_lens_to_be_saved_again() -> None:
    run = Run()
    bench = bench_of(run, Saved("0 floor markers were seen"))
    eye = np.eye(3)
    bench._lens = Lens((640, 480), eye, np.zeros(5), 0.1, 5, (), (), "brown")
    for _ in range(2):
        with pytest.raises(RefusedError, match="not saved: 0 floor markers were seen"):
            bench.save()


def test_what_the_page_does_not_calibrate_is_refused_with_the_command_that_does() -> None:
    config = small_config()
    fisheye = replace(CALIBRATION, lens_model="fisheye", distortion=np.zeros(4))
    for bench, why in (
        (bench_of(Run(), Saved(), calibration=fisheye), "clearway calibrate --live"),
        (bench_of(Run(), Saved(), several(config)), "one by one: clearway calibrate --live"),
        (bench_of(Run(), Saved(), without_file(config)), "names no file"),
    ):
        assert why in bench.facts()["refusal"]
        with pytest.raises(RefusedError, match=why):
            bench.start(CHARUCO)


def several(config: Config) -> Config:
    return config.model_copy(update={"cameras": ({"name": "left"}, {"name": "right"})})


def without_file(config: Config) -> Config:
    camera = config.camera.model_copy(update={"calibration": None, "metres_per_pixel": 0.002})
    return config.model_copy(update={"camera": camera})


def test_a_board_is_what_was_typed() -> None:
    assert board_of(TYPED) == CHARUCO
    plain = board_of({"kind": "chessboard", "squares": "9x6", "square_mm": "25", "marker_mm": "x"})
    assert (plain.columns, plain.rows, plain.square_m) == (9, 6, 0.025)


@pytest.mark.parametrize(
    ("typed", "why"),
    [
        ({"kind": "circles"}, "must be charuco or chessboard"),
        ({"squares": "8"}, "two whole numbers"),
        ({"squares": "1x1"}, r"both must be in 3\.\.200"),
        ({"square_mm": "wide"}, "square_mm: must be a number"),
        ({"square_mm": "nan"}, "must be in"),
        ({"marker_mm": "120"}, "must be smaller than the square"),
        ({"squares": ["8x6"]}, "two whole numbers"),
    ],
)
def test_a_board_that_is_none_is_refused_in_a_sentence(typed: dict[str, Any], why: str) -> None:
    with pytest.raises(RefusedError, match=why):
        board_of({**TYPED, **typed})


def test_a_board_of_an_unknown_dictionary_is_refused_and_a_short_name_is_a_name() -> None:
    with pytest.raises(RefusedError, match="marker dictionary 'DICT_5X5_101' is unknown; did you"):
        board_of({**TYPED, "dictionary": "DICT_5X5_101"})
    assert board_of({**TYPED, "dictionary": "5x5_100"}).dictionary == "5x5_100"
    assert board_of({**TYPED, "kind": "chessboard", "dictionary": "none"}).kind == "chessboard"
