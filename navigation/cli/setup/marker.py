"""``clearway marker``: a marker or a board to print."""

from __future__ import annotations

from pathlib import Path

import click

from navigation.cli.outputs import write_bytes
from navigation.cli.setup.starter_values import OWN_MARKER_M


@click.command("marker")
@click.argument("marker_id", metavar="[ID]", type=click.IntRange(min=0), required=False)
@click.option("--dictionary", default=None, help="OpenCV's name; DICT_4X4_50 for a marker.")
@click.option(
    "--size-mm",
    type=float,
    default=1000.0 * OWN_MARKER_M,
    show_default=True,
    help="The black square's side.",
)
@click.option(
    "--board", type=click.Choice(["charuco", "chessboard"]), help="A calibration board instead."
)
@click.option(
    "--squares", default=None, help="charuco: squares; chessboard: inner corners, e.g. 9x6."
)
@click.option("--square-mm", type=float, default=25.0, show_default=True, help="A square's side.")
@click.option(
    "--paper",
    type=click.Choice(["a4", "a3", "letter"]),
    default="a4",
    show_default=True,
    help="The paper to print on.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    multiple=True,
    help="A .pdf or .png file; repeatable. Default: both, named after the drawing.",
)
def command(
    marker_id: int | None,
    dictionary: str | None,
    size_mm: float,
    board: str | None,
    squares: str | None,
    square_mm: float,
    paper: str,
    output: tuple[Path, ...],
) -> None:
    """Write the marker ID, or a board, as PDF and PNG that print at true size."""
    if (marker_id is None) == (board is None):
        raise click.UsageError(
            "give a marker's ID, or --board for a calibration board"
            + ("" if board is None else ", not both")
        )
    for path in output:
        if path.suffix.lower() not in (".pdf", ".png"):
            raise click.UsageError(f"-o {path}: must end in .pdf or .png")
    from vision.calibrate.sheet import board_sheet, marker_sheet, pdf_bytes, png_bytes

    if marker_id is not None:
        name = dictionary or "DICT_4X4_50"
        sheet = marker_sheet(marker_id, name, size_mm)
        stem = f"marker-{name.removeprefix('DICT_').lower()}-{marker_id}"
    else:
        from navigation.cli.setup.calibrate import board_spec

        spec = board_spec(str(board), squares, square_mm, None, dictionary)
        sheet = board_sheet(spec)
        stem = f"{spec.kind}-{spec.columns}x{spec.rows}"
    for path in output or (Path(f"{stem}.pdf"), Path(f"{stem}.png")):
        data = pdf_bytes(sheet, paper) if path.suffix.lower() == ".pdf" else png_bytes(sheet)
        write_bytes(path, data)
        click.echo(f"{path}: {sheet.label}")
