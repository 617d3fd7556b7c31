"""Markers and boards at true size on paper: PDF and PNG.

Rules and units
- A sheet is dark rectangles (x, y, width, height) in millimetres from its upper left corner, y
  down, with a text and a ruler.
- The PDF has one page, one filled path (without seams), Helvetica, which every reader has.
- It outlines a marker's forward direction, or a board's first corner and axes, beside the drawing,
  away from detectors.
- The PNG holds the drawing alone, in whole pixels a cell; its resolution (pHYs) prints true too.
"""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardSpec
from vision.markers.marker_pattern import pattern_bits
from vision.markers.marker_search import MarkerError, dictionary_by_name

Rectangle = tuple[float, float, float, float]
Arrow = tuple[float, float, float, float, str]

PAPERS_MM = {"a4": (210.0, 297.0), "a3": (297.0, 420.0), "letter": (215.9, 279.4)}
"""Papers' (width, height) upright."""

_POINTS_PER_MM = 72.0 / 25.4
_MARGIN_MM = 10.0
_TEXT_MM = 14.0
_RULER_MM = 100.0
_DOTS_PER_MM = 300.0 / 25.4
_FIRST_CORNER = "first corner: where x and y meet"
_ARROW_MM, _HEAD_MM = 7.0, 2.0


@dataclass(frozen=True, slots=True)
class Sheet:
    """A drawing of ``width_mm`` x ``height_mm``: dark rectangles, cell and label.

    ``arrows`` are (x, y, dx, dy, words) in millimetres, y down, on paper only.
    """

    width_mm: float
    height_mm: float
    cell_mm: float
    dark: tuple[Rectangle, ...]
    label: str
    arrows: tuple[Arrow, ...] = ()


def marker_sheet(marker_id: int, dictionary: str, size_mm: float) -> Sheet:
    """A marker with a black square of side ``size_mm`` and a white rim of one cell."""
    book = dictionary_by_name(dictionary)
    if not 0 <= marker_id < len(book.bytesList):
        raise MarkerError(
            f"marker id = {marker_id}: {dictionary} has ids 0 to {len(book.bytesList) - 1}"
        )
    if not 1.0 <= size_mm <= 1000.0:
        raise MarkerError(f"size = {size_mm} mm: must be in 1..1000 mm")
    n = book.markerSize + 2
    cell = size_mm / n
    dark = _cells(_bits(book, marker_id), cell, cell, cell)
    side = size_mm + 2.0 * cell
    label = f"{dictionary}  id {marker_id}  {size_mm:g} mm (black square)"
    arrow = (side + 1.0, 0.5 * side, _ARROW_MM, 0.0, "forward")
    return Sheet(side, side, cell, dark, label, (arrow,))


def board_sheet(board: BoardSpec) -> Sheet:
    """A chessboard, or a ChArUco board in OpenCV's present layout."""
    square = 1000.0 * board.square_m
    if board.kind == "chessboard":
        columns, rows = board.columns + 1, board.rows + 1
        parity = np.add.outer(np.arange(rows), np.arange(columns)) % 2
        dark = _cells(parity == 0, square, square, square)
        label = (
            f"chessboard {board.columns}x{board.rows} inner corners, squares of {square:g} mm; "
            f"{_FIRST_CORNER}"
        )
        size = (columns + 2) * square, (rows + 2) * square
        return Sheet(*size, square, dark, label, _axes(2.0 * square, 2.0 * square, size))
    layout = board.charuco()
    book, marker = layout.getDictionary(), 1000.0 * board.marker_side_m
    parity = np.add.outer(np.arange(board.rows), np.arange(board.columns)) % 2
    rim = square / 4.0
    parts = list(_cells(parity == 0, square, rim, rim))
    for marker_id, corners in zip(np.ravel(layout.getIds()), layout.getObjPoints(), strict=True):
        x, y = (1000.0 * float(v) for v in np.asarray(corners).reshape(-1, 3)[0, :2])
        bits = _bits(book, int(marker_id))
        parts += _cells(bits, marker / bits.shape[0], rim + x, rim + y)
    label = (
        f"ChArUco {board.columns}x{board.rows} squares of {square:g} mm, markers of {marker:g} mm, "
        f"{board.dictionary}; {_FIRST_CORNER}"
    )
    width, height = board.columns * square + 2 * rim, board.rows * square + 2 * rim
    axes = _axes(rim + square, rim + square, (width, height))
    return Sheet(width, height, marker / (book.markerSize + 2), tuple(parts), label, axes)


def _axes(x: float, y: float, size: tuple[float, float]) -> tuple[Arrow, ...]:
    return (
        (size[0] + 1.0, y, _ARROW_MM, 0.0, "x"),
        (x, -1.0, 0.0, -_ARROW_MM, "y"),
    )


def pdf_bytes(sheet: Sheet, paper: str = "a4") -> bytes:
    """Centre the sheet on a page, turned only if needed to fit.

    Raises ``MarkerError`` for an unknown or too small paper.
    """
    if paper not in PAPERS_MM:
        raise MarkerError(f"paper '{paper}': must be one of {', '.join(PAPERS_MM)}")
    width, height = _page_for(sheet, paper)
    left = (width - sheet.width_mm) / 2.0
    top = (height - sheet.height_mm - _TEXT_MM) / 2.0
    content = ["0 g"]
    for x, y, w, h in sheet.dark:
        content.append(_rectangle(left + x, height - top - y - h, w, h))
    content.append("f")
    for x, y, dx, dy, words in sheet.arrows:
        content += _arrow(left + x, height - top - y, dx, -dy, words)
    content += _foot(sheet, width, top)
    return _pdf("\n".join(content).encode("ascii"), width, height)


def png_bytes(sheet: Sheet) -> bytes:
    """The drawing at about 300 dots an inch, with its exact resolution."""
    cell_px = max(2, round(sheet.cell_mm * _DOTS_PER_MM))
    dots_per_mm = cell_px / sheet.cell_mm
    size = (round(sheet.width_mm * dots_per_mm), round(sheet.height_mm * dots_per_mm))
    picture = np.full((size[1], size[0]), 255, np.uint8)
    for x, y, w, h in sheet.dark:
        x0, y0, x1, y1 = (round(v * dots_per_mm) for v in (x, y, x + w, y + h))
        picture[y0:y1, x0:x1] = 0
    encoded, data = cv2.imencode(".png", picture)
    if not encoded:
        raise MarkerError(f"a picture of {size[0]}x{size[1]} pixels cannot be written as PNG")
    raw = data.tobytes()
    resolution = round(1000.0 * dots_per_mm)
    # any chunk may follow signature (8 bytes) and header chunk (25)
    return raw[:33] + _chunk(b"pHYs", struct.pack(">IIB", resolution, resolution, 1)) + raw[33:]


def _bits(book: cv2.aruco.Dictionary, marker_id: int) -> NDArray[np.bool_]:
    """(n, n) True for a dark cell, with the black border."""
    return np.asarray(pattern_bits(book, marker_id) == 0.0)


def _cells(dark: NDArray[np.bool_], cell: float, left: float, top: float) -> tuple[Rectangle, ...]:
    found = []
    for row, line in enumerate(np.asarray(dark, dtype=np.int8)):
        steps = np.diff(np.concatenate([[0], line, [0]]))
        for start, end in zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1), strict=True):
            width = float(end - start) * cell
            found.append((left + float(start) * cell, top + row * cell, width, cell))
    return tuple(found)


def _page_for(sheet: Sheet, paper: str) -> tuple[float, float]:
    width, height = PAPERS_MM[paper]
    for page in ((width, height), (height, width)):
        if (
            sheet.width_mm <= page[0] - 2 * _MARGIN_MM
            and sheet.height_mm + _TEXT_MM <= page[1] - 2 * _MARGIN_MM
        ):
            return page
    raise MarkerError(
        f"{sheet.width_mm:.0f} x {sheet.height_mm:.0f} mm: does not fit on {paper} paper with "
        f"margins of {_MARGIN_MM:g} mm; take a larger paper or a smaller size"
    )


def _foot(sheet: Sheet, width: float, bottom: float) -> list[str]:
    base = bottom + 2.0
    left = (width - _RULER_MM) / 2.0
    text = sheet.label.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
    return [
        _rectangle(left, base, _RULER_MM, 0.2),
        _rectangle(left, base - 1.0, 0.2, 2.2),
        _rectangle(left + _RULER_MM - 0.2, base - 1.0, 0.2, 2.2),
        "f",
        f"BT /F1 9 Tf {_points(left)} {_points(base + 3.5)} Td ({text}) Tj ET",
        f"BT /F1 7 Tf {_points(left)} {_points(base - 4.0)} Td "
        "(print at 100 %: this ruler must measure 100 mm) Tj ET",
    ]


def _arrow(x: float, y: float, dx: float, dy: float, words: str) -> list[str]:
    length = math.hypot(dx, dy)
    ux, uy = dx / length, dy / length
    tip = x + dx, y + dy
    back = tip[0] - _HEAD_MM * ux, tip[1] - _HEAD_MM * uy
    half = 0.5 * _HEAD_MM
    head = [
        tip,
        (back[0] - half * uy, back[1] + half * ux),
        (back[0] + half * uy, back[1] - half * ux),
    ]
    (ax, ay), (bx, by), (cx, cy) = [(_points(a), _points(b)) for a, b in head]
    text_x, text_y = (x, y + 1.5) if dx else (x + 1.5, y + 0.4 * dy)
    return [
        f"0.8 w {_points(x)} {_points(y)} m {_points(back[0])} {_points(back[1])} l S",
        f"{ax} {ay} m {bx} {by} l {cx} {cy} l h f",
        f"BT /F1 7 Tf {_points(text_x)} {_points(text_y)} Td ({words}) Tj ET",
    ]


def _rectangle(x: float, y: float, w: float, h: float) -> str:
    return f"{_points(x)} {_points(y)} {_points(w)} {_points(h)} re"


def _points(value_mm: float) -> str:
    return f"{value_mm * _POINTS_PER_MM:.4f}"


def _pdf(content: bytes, width: float, height: float) -> bytes:
    """One page of PDF 1.4 (ISO 32000-1, 7.5)."""
    box = f"[0 0 {_points(width)} {_points(height)}]"
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox {box} /Contents 4 0 R "
        "/Resources << /Font << /F1 5 0 R >> >> >>".encode("ascii"),
        b"<< /Length %d >>\nstream\n%s\nendstream" % (len(content), content),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ]
    out = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
    places = []
    for number, body in enumerate(objects, start=1):
        places.append(len(out))
        out += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    table = len(out)
    out += b"xref\n0 %d\n0000000000 65535 f \n" % (len(objects) + 1)
    for place in places:
        out += b"%010d 00000 n \n" % place
    out += b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (
        len(objects) + 1,
        table,
    )
    return bytes(out)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
