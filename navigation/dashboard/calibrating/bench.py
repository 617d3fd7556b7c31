"""Calibrates a lens while a run is at rest: from the start to a saved lens, or to a cancel.

Rules
- While the camera is lent the robot holds, whatever the orders; STOP works as always, and the run
  keeps looking.
- It calibrates one camera's Brown lens. Anything else is refused, naming the command for it.
- Only a save writes; a cancel, an error and the end of the run write nothing.
- The views are taken in a separate thread; any thread may call every method.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any, Final, Literal, Protocol, TypeAlias

from navigation.config import Config
from navigation.config.values import SIMULATED
from navigation.dashboard.calibrating.frames import LentFrames
from navigation.dashboard.calibrating.shown import ShownViews
from navigation.dashboard.visits import RefusedError
from navigation.simulator.picture.held_board import HeldBoardCamera
from vision.calibrate.board import BoardSpec
from vision.calibrate.lens import MIN_VIEWS, Lens, estimate_lens
from vision.calibrate.live.session import LiveSession
from vision.calibrate.live.taking import take_live
from vision.calibration.calibration import Calibration, CalibrationError
from vision.camera.camera import Camera, CameraError, Clock, Frame, Image
from vision.markers.marker_search import MarkerError, dictionary_by_name

Phase: TypeAlias = Literal["idle", "taking", "fitting", "found"]
LENT: Final = "the camera is being calibrated from the page"
ENDS_WITHIN_S: Final = 2.0


class LendingRun(Protocol):
    """The run's side of the loan."""

    lent: str | None
    """Why the robot has to hold, None where the camera is not lent."""

    @property
    def frame(self) -> Frame | None:
        """The newest picture."""
        ...


class Bench:
    """Calibrates the lens of one run's camera.

    ``save`` replaces the present lens, given the newest picture of the arena, and returns a
    sentence; it raises ``ValueError``. ``clock`` gives monotonic seconds, ``wait`` lets them pass.
    """

    def __init__(
        self,
        run: LendingRun,
        config: Config,
        calibration: Calibration,
        save: Callable[[Lens, Image | None], str],
        clock: Clock,
        wait: Callable[[float], None],
    ) -> None:
        self._run, self._config, self._save = run, config, save
        self._clock, self._wait = clock, wait
        self._refusal = _refusal(config, calibration)
        self._lock = threading.Lock()
        self._phase: Phase = "idle"
        self._cancelled = threading.Event()
        self._thread: threading.Thread | None = None
        self._lens: Lens | None = None
        self._views = ShownViews()
        self._said = ""

    def facts(self) -> dict[str, Any]:
        """Everything that the page shows."""
        facts = {"refusal": self._refusal, "phase": self._phase, "said": self._said}
        return {**facts, **self._views.facts()}

    def picture(self, number: str) -> bytes | None:
        """Frame of a state, or the newest if it is gone; None without any."""
        return self._views.picture(number)

    def start(self, spec: BoardSpec) -> str:
        """Borrow the camera and take views of this board; ``RefusedError`` if impossible."""
        with self._lock:
            if self._refusal:
                raise RefusedError(self._refusal)
            if self._phase != "idle":
                raise RefusedError(f"{LENT} already")
            self._run.lent = LENT
            self._phase, self._said, self._lens = "taking", "", None
            self._views = ShownViews()
            self._cancelled = threading.Event()
            self._thread = threading.Thread(
                target=self._take,
                args=(spec, self._views, self._cancelled),
                name="calibration",
                daemon=True,
            )
            self._thread.start()
        return "calibrates the camera; the robot holds meanwhile"

    def cancel(self) -> str:
        """Give the camera back and write nothing; harmless if nothing is under way."""
        with self._lock:
            self._cancelled.set()
            was, self._phase = self._phase, "idle"
            self._lens, self._run.lent = None, None
            self._said = "cancelled: nothing was written" if was != "idle" else self._said
        return "the calibration is cancelled" if was != "idle" else "no calibration is under way"

    def save(self) -> str:
        """Save the found lens, and give the camera back."""
        with self._lock:
            if self._lens is None:
                raise RefusedError("no lens was found yet")
            frame = self._run.frame
            try:
                said = self._save(self._lens, None if frame is None else frame.image)
            except ValueError as error:
                raise RefusedError(f"not saved: {error}") from None
            self._phase, self._said = "idle", said
            self._lens, self._run.lent = None, None
        return said

    def close(self) -> None:
        """Cancel at the end of the run."""
        self.cancel()
        if self._thread is not None:
            self._thread.join(ENDS_WITHIN_S)

    # In the thread.

    def _take(self, spec: BoardSpec, views: ShownViews, cancelled: threading.Event) -> None:
        try:
            session = LiveSession(spec)
            camera = self._camera(spec, session)
            taken = take_live(camera, spec, session, [views], self._clock, cancelled.is_set)
            if len(taken.views) < MIN_VIEWS:
                raise CalibrationError(
                    f"{len(taken.views)} views of the board were taken, at least {MIN_VIEWS} are "
                    "needed"
                )
            self._turn("taking", "fitting", cancelled)
            lens = estimate_lens(taken.views)
        except (CalibrationError, CameraError) as error:
            self._fail(f"{error}: nothing was written", cancelled)
        except Exception as error:  # noqa: BLE001 - the camera is given back, and the run continues
            self._fail(f"{type(error).__name__}: {error}: nothing was written", cancelled)
        else:
            self._find(lens, cancelled)

    def _camera(self, spec: BoardSpec, session: LiveSession) -> Camera:
        if self._config.camera.source != SIMULATED:
            return LentFrames(lambda: self._run.frame, self._clock, self._wait)
        seed = 0 if self._config.simulation is None else self._config.simulation.seed
        return HeldBoardCamera(
            self._config, spec, self._clock, self._wait, seed, session.wanted_pose
        )

    def _turn(self, before: Phase, after: Phase, cancelled: threading.Event) -> None:
        with self._lock:
            if self._phase == before and not cancelled.is_set():
                self._phase = after

    def _fail(self, sentence: str, cancelled: threading.Event) -> None:
        with self._lock:
            if not cancelled.is_set():
                self._phase, self._said, self._run.lent = "idle", sentence, None

    def _find(self, lens: Lens, cancelled: threading.Event) -> None:
        with self._lock:
            if cancelled.is_set():
                return
            self._phase, self._lens = "found", lens
            self._said = "; ".join(
                (
                    f"found: {lens.rms_px:.3f} px rms over {len(lens.used)} views, focal length "
                    f"{lens.camera_matrix[0, 0]:.0f} px",
                    *lens.remarks,
                    "put the board away, then save",
                )
            )


def _refusal(config: Config, calibration: Calibration) -> str:
    """Reason why this run's camera cannot be calibrated from the page; else empty."""
    if config.cameras:
        return "several cameras are calibrated one by one: clearway calibrate --live"
    if calibration.lens_model != "brown":
        return (
            f"the lens is a {calibration.lens_model} one, which clearway calibrate --live "
            "calibrates: from the page a lens is Brown's"
        )
    if config.camera.calibration is None:
        return "camera.calibration names no file: clearway calibrate makes the first one"
    return ""


def board_of(words: Mapping[str, Any]) -> BoardSpec:
    """Typed board: ``kind``, ``squares`` as 7x5, ``square_mm``, ``marker_mm``, ``dictionary``;
    ``RefusedError`` says what is wrong.
    """
    kind = words.get("kind")
    if kind not in ("charuco", "chessboard"):
        raise RefusedError("board: must be charuco or chessboard")
    sides = str(words.get("squares", "")).lower().split("x")
    if len(sides) != 2 or not all(one.strip().isdecimal() and len(one) < 5 for one in sides):
        raise RefusedError("squares: must be two whole numbers such as 7x5")
    marker_mm = None
    if kind == "charuco" and str(words.get("marker_mm", "")).strip():
        marker_mm = _number(words, "marker_mm")
    dictionary = str(words.get("dictionary") or "DICT_6X6_250")
    try:
        if kind == "charuco":
            dictionary_by_name(dictionary)
        return BoardSpec(
            kind,
            int(sides[0]),
            int(sides[1]),
            _number(words, "square_mm") / 1000.0,
            None if marker_mm is None else marker_mm / 1000.0,
            dictionary,
        )
    except (CalibrationError, MarkerError) as error:
        raise RefusedError(str(error)) from None


def _number(words: Mapping[str, Any], name: str) -> float:
    try:
        return float(str(words.get(name)))
    except ValueError:
        raise RefusedError(f"{name}: must be a number") from None
