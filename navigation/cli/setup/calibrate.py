"""``clearway calibrate``: the lens from a board, the arena from surveyed points."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from navigation.cli.options import POSITIVE, STATION, StationArgument
from navigation.cli.outputs import keep_apart

if TYPE_CHECKING:
    from vision.calibrate.board import BoardSpec, BoardView
    from vision.calibrate.lens import Lens
    from vision.calibrate.survey import Survey
    from vision.camera.camera import Image

_FILE = click.Path(dir_okay=False, path_type=Path)


@click.command("calibrate")
@click.argument("pictures", nargs=-1, type=click.Path(path_type=Path))
@click.option(
    "--live",
    "--camera",
    "live",
    metavar="SOURCE",
    help="Take the views from this camera, live: a source, or a configuration.",
)
@click.option(
    "--limit-px",
    type=POSITIVE,
    help="--live ends where the lens is known so well everywhere in the picture; default 0.3.",
)
@click.option(
    "--page",
    type=click.IntRange(0, 65535),
    metavar="PORT",
    help="Show --live on a page at this port of this machine, too; 0 takes any.",
)
@click.option(
    "--board",
    type=click.Choice(["charuco", "chessboard"]),
    default="charuco",
    show_default=True,
    help="The kind of board in the pictures.",
)
@click.option("--squares", help="charuco: squares, 5x7; chessboard: inner corners, 9x6.")
@click.option("--square-mm", type=float, default=25.0, show_default=True, help="A square's side.")
@click.option("--marker-mm", type=float, help="A ChArUco marker's side; default half a square.")
@click.option("--dictionary", help="Dictionary of the ChArUco board; default DICT_6X6_250.")
@click.option(
    "--terms", type=click.Choice(["0", "1", "2", "4", "5"]), help="Distortion terms; default: best."
)
@click.option(
    "--lens-model",
    type=click.Choice(["auto", "brown", "fisheye"]),
    default="auto",
    show_default=True,
    help="The lens's model; auto: what fits pictures left out better.",
)
@click.option("--lens", "lens_file", type=_FILE, help="Take the lens from this calibration.")
@click.option("--points", type=_FILE, help="Surveyed points of the arena: px,py,x_m,y_m lines.")
@click.option("--floor-picture", type=_FILE, help="A picture of the arena with the board on it.")
@click.option("--floor-at", type=STATION, help="Place of that board's first corner; default 0,0,0.")
@click.option("--camera-height-m", type=float, help="The camera's height above the floor.")
@click.option("--size", help="WIDTHxHEIGHT, for --points without any picture.")
@click.option(
    "-o",
    "--output",
    type=_FILE,
    default=Path("calibration.yaml"),
    show_default=True,
    help="The calibration to write.",
)
def command(  # noqa: PLR0913 (an argument for each option of the command line)
    pictures: tuple[Path, ...],
    live: str | None,
    limit_px: float | None,
    page: int | None,
    board: str,
    squares: str | None,
    square_mm: float,
    marker_mm: float | None,
    dictionary: str | None,
    terms: str | None,
    lens_model: str,
    lens_file: Path | None,
    points: Path | None,
    floor_picture: Path | None,
    floor_at: StationArgument | None,
    camera_height_m: float | None,
    size: str | None,
    output: Path,
) -> None:
    """Calibrate a camera from PICTURES of a board, or live, and place it above the arena.

    With --live the views are taken automatically: it shows which parts of the picture still need
    the board and how to hold it, takes a view when the board is at rest, and ends when the lens is
    known well enough.

    With --points or --floor-picture the result maps pixels to the arena's metres; without them only
    the lens is written, for --lens of a later call. Pictures and points that do not fit are named
    and left out.
    """
    if lens_file is not None and (pictures or live is not None):
        raise click.UsageError("--lens takes the place of pictures and of --live")
    if pictures and live is not None:
        raise click.UsageError("give pictures of a board, or --live")
    if live is None and (limit_px is not None or page is not None):
        raise click.UsageError("--limit-px and --page need --live")
    if not pictures and live is None and points is None and floor_picture is None:
        raise click.UsageError("give pictures of a board, --live, --points or --floor-picture")
    from navigation.cli.calibrating.chosen_lens import lens_from_views
    from navigation.cli.calibrating.command import taken_live

    # the calibration whose lens is taken may be the one being made
    read = (*pictures, points, floor_picture)
    keep_apart((("--output", output),), read)
    given_size = None if size is None else _pair(size, "--size")
    spec = None
    if pictures or live is not None or (floor_picture is not None and points is None):
        spec = board_spec(board, squares, square_mm, marker_mm, dictionary)
    lens = None
    if spec is not None and (pictures or live is not None):
        if live is None:
            views = _taken_from_pictures(pictures, spec)
        else:
            views = taken_live(live, spec, limit_px, page)
        lens = lens_from_views(views, None if terms is None else int(terms), lens_model)
    if lens_file is not None:
        lens = _known_lens(lens_file)
    if points is None and floor_picture is None:
        if lens is not None:
            _save_lens_alone(lens, output)
        return
    floor = _read(floor_picture) if floor_picture is not None else None
    survey = _survey(points, floor, floor_picture, spec, floor_at)
    _place(survey, _size(floor, lens, given_size), lens, camera_height_m, output)


def board_spec(
    board: str,
    squares: str | None,
    square_mm: float,
    marker_mm: float | None,
    dictionary: str | None,
) -> BoardSpec:
    """The board that the options describe."""
    from vision.calibrate.board import BoardSpec

    if board != "charuco" and (dictionary or marker_mm is not None):
        option = "--dictionary" if dictionary else "--marker-mm"
        raise click.UsageError(f"{option}: a chessboard has no markers; --board charuco has")
    text = squares or ("5x7" if board == "charuco" else "9x6")
    columns, rows = _pair(text, "--squares")
    return BoardSpec(
        "charuco" if board == "charuco" else "chessboard",
        columns,
        rows,
        square_mm / 1000.0,
        None if marker_mm is None else marker_mm / 1000.0,
        dictionary or "DICT_6X6_250",
    )


def _pair(text: str, option: str) -> tuple[int, int]:
    words = text.lower().split("x")
    if len(words) != 2 or not all(word.strip().isdecimal() for word in words):
        raise click.UsageError(f"{option} {text}: must be two whole numbers such as 9x6")
    return int(words[0]), int(words[1])


def _read(path: Path) -> Image:
    """The picture as its sensor saw it; ``CameraError``."""
    from navigation.cli.decoder_lines import caught_decoder_lines
    from vision.camera.camera import CameraError
    from vision.camera.picture_turn import orientation
    from vision.camera.sources import read_picture

    with caught_decoder_lines() as said:
        picture = read_picture(path)
    if said.damage:
        raise CameraError(f"{path}: a damaged picture: {said.damage}")
    if said.doubt:
        click.echo(f"{path}: the picture may be damaged: {said.doubt}", err=True)
    told = orientation(path.read_bytes())
    if told != 1:
        click.echo(
            f"{path}: its EXIF orientation, {told}, is ignored: pixels are the sensor's",
            err=True,
        )
    return picture


def _read_all(paths: tuple[Path, ...]) -> list[tuple[str, Image]]:
    """The pictures and those in folders; damaged ones are reported and left out."""
    from vision.camera.camera import CameraError
    from vision.camera.sources import PICTURE_SUFFIXES

    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            files += sorted(p for p in path.iterdir() if p.suffix.lower() in PICTURE_SUFFIXES)
        else:
            files.append(path)
    taken: list[tuple[str, Image]] = []
    for path in files:
        try:
            taken.append((str(path), _read(path)))
        except CameraError as error:
            if not path.exists() or len(files) == 1:
                raise
            click.echo(f"{error}: left out", err=True)
    return taken


def _taken_from_pictures(pictures: tuple[Path, ...], spec: BoardSpec) -> list[BoardView]:
    from vision.calibrate.board import find_boards

    views, without = find_boards(_read_all(pictures), spec)
    for missing in without:
        click.echo(f"{missing.name}: left out: {missing.reason}", err=True)
    return views


def _save_lens_alone(lens: Lens, output: Path) -> None:
    from vision.calibration.calibration_file import save_lens

    save_lens(output, lens.size, lens.camera_matrix, lens.distortion, lens.rms_px, lens.model)
    click.echo(f"written: {output}, the lens alone: without --points or --floor-picture the")
    click.echo(f"arena is not placed; --lens {output} with one of them places it")


def _known_lens(path: Path) -> Lens:
    import numpy as np

    from vision.calibrate.lens import Lens
    from vision.calibration.calibration import CalibrationError, nominal_camera_matrix
    from vision.calibration.calibration_file import load_lens
    from vision.calibration.lens_model import STRAIGHT

    known = load_lens(path)
    supposed = np.array_equal(known.camera_matrix, nominal_camera_matrix(known.size))
    if known.lens_rms_px is None and supposed and known.lens.model == STRAIGHT:
        raise CalibrationError(
            f"{path}: has no lens: it was made without pictures of a board, "
            "and its focal length is supposed"
        )
    terms = 0
    for index, term in enumerate(known.distortion.tolist(), start=1):
        terms = index if term != 0.0 else terms
    rms_px = known.lens_rms_px if known.lens_rms_px is not None else 0.0
    return Lens(
        known.size, known.camera_matrix, known.distortion, rms_px, terms, (), (), known.lens_model
    )


def _survey(
    points: Path | None,
    floor: Image | None,
    floor_picture: Path | None,
    spec: BoardSpec | None,
    floor_at: StationArgument | None,
) -> Survey:
    from vision.calibrate.board import NoBoard, find_board
    from vision.calibrate.survey import board_survey, read_survey
    from vision.calibration.calibration import CalibrationError

    if points is not None:
        return read_survey(points)
    if floor is None or spec is None:
        raise click.UsageError("give --points or --floor-picture")
    view = find_board(floor, spec, str(floor_picture))
    if isinstance(view, NoBoard):
        raise CalibrationError(f"{view.name}: {view.reason}")
    if spec.looks_the_same_turned:
        px, py = view.corners_px[0]
        click.echo(
            f"{view.name}: this chessboard looks the same turned by half a turn: the first corner "
            f"is taken to be the one at ({px:.0f}, {py:.0f}) px",
            err=True,
        )
    at = floor_at or StationArgument(0.0, 0.0)
    return board_survey(view, (at.x, at.y), at.heading_rad or 0.0)


def _size(floor: Image | None, lens: Lens | None, size: tuple[int, int] | None) -> tuple[int, int]:
    if floor is not None:
        return int(floor.shape[1]), int(floor.shape[0])
    if lens is not None:
        return lens.size
    if size is None:
        raise click.UsageError("--points alone needs the picture's --size WIDTHxHEIGHT")
    return size


def _place(
    survey: Survey,
    size: tuple[int, int],
    lens: Lens | None,
    camera_height_m: float | None,
    output: Path,
) -> None:
    from vision.calibrate.survey import fit_arena
    from vision.calibration.calibration_file import save_calibration

    fit = fit_arena(survey, size, lens, camera_height_m)
    calibration = fit.calibration
    told = lens.remarks if lens is not None else ()
    for remark in calibration.remarks:
        if remark not in told:
            click.echo(remark, err=True)
    rms = calibration.arena_rms_m
    residual = "no residual" if rms is None else f"{1000.0 * rms:.2f} mm rms"
    click.echo(
        f"arena: {residual} over {sum(fit.used)} of {len(fit.used)} points, "
        f"{1000.0 * calibration.metres_per_pixel:.3f} mm a pixel"
    )
    if calibration.camera_center_m is not None:
        x, y, z = calibration.camera_center_m
        click.echo(f"camera: {z:.3f} m above the floor at ({x:.3f}, {y:.3f})")
    save_calibration(calibration, output)
    click.echo(f"written: {output}")
