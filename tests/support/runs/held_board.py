"""A simulated camera with a board in the hand, small and in virtual time."""

from __future__ import annotations

from pathlib import Path

from navigation.config import Config, load_config
from navigation.simulator.picture.held_board import HeldBoardCamera
from vision.calibrate.board import BoardSpec
from vision.calibrate.live.session import LiveSession, LiveState
from vision.camera.camera import Frame

CHARUCO = BoardSpec("charuco", 8, 6, 0.1, 0.075, "DICT_5X5_100")
CHESSBOARD = BoardSpec("chessboard", 9, 6, 0.08)
FOCAL_PX = 617.0
CONFIG = Path(__file__).parents[3] / "configs" / "simulation.yaml"


class VirtualTime:
    """A clock that only waiting advances, and each frame by a tenth of a second."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def clock(self) -> float:
        return self.now_s

    def wait(self, seconds: float) -> None:
        self.now_s += seconds


def small_config(**camera: float) -> Config:
    """The simulation's camera with pictures of a quarter of the size, ten a second.

    Without noise (``noise_grey=0.0``) a lens is found in a third of the views.
    """
    config = load_config(CONFIG, {})
    assert config.simulation is not None
    lens = config.simulation.camera.model_copy(update={"focal_px": FOCAL_PX, **camera})
    return config.model_copy(
        update={
            "camera": config.camera.model_copy(update={"size_px": (640, 480), "rate_hz": 10.0}),
            "simulation": config.simulation.model_copy(update={"camera": lens}),
        }
    )


def held_board(
    spec: BoardSpec, session: LiveSession | None, time: VirtualTime, seed: int = 0
) -> HeldBoardCamera:
    """The camera; the board does what a session asks, or wanders about."""
    asked = {} if session is None else {"asked": session.wanted_pose}
    return HeldBoardCamera(small_config(), spec, time.clock, time.wait, seed, **asked)


def states(count: int) -> list[tuple[LiveState, Frame]]:
    """The first states of a live calibration, each with its frame."""
    session, time = LiveSession(CHARUCO), VirtualTime()
    camera = held_board(CHARUCO, session, time)
    camera.open()
    found = []
    for _ in range(count):
        frame = camera.read(1.0)
        assert frame is not None
        found.append((session.look(frame), frame))
    return found
