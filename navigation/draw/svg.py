"""A drawing as SVG text: two decimals, no script, no outside resources."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from xml.sax.saxutils import escape, quoteattr

from navigation.draw.shapes import (
    PAGE,
    Area,
    Colour,
    DiscShape,
    Drawing,
    Label,
    Motion,
    Photo,
    Shape,
    Strokes,
)
from planner.scene import FloatArray

FONT = "DejaVu Sans, Helvetica, Arial, sans-serif"


def to_svg(drawing: Drawing) -> str:
    """The whole SVG document."""
    return "\n".join(_lines(drawing)) + "\n"


def _lines(drawing: Drawing) -> Iterator[str]:
    w, h = drawing.width, drawing.height
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}"'
        f' viewBox="0 0 {w} {h}" font-family="{FONT}" stroke-linecap="round"'
        ' stroke-linejoin="round">'
    )
    yield f"<title>{escape(drawing.title)}</title>"
    yield f'<rect width="{w}" height="{h}" fill="{_hex(PAGE)}"/>'
    x0, y0, x1, y1 = drawing.view
    yield (
        f'<clipPath id="view"><rect x="{x0 - 1:.2f}" y="{y0 - 1:.2f}"'
        f' width="{x1 - x0 + 2:.2f}" height="{y1 - y0 + 2:.2f}"/></clipPath>'
    )
    for layer in drawing.layers:
        if layer.shapes:
            clip = ' clip-path="url(#view)"' if layer.clipped else ""
            yield f"<g id={quoteattr(layer.name.replace(' ', '-'))}{clip}>"
            yield f"<title>{escape(layer.name)}</title>"
            for shape in layer.shapes:
                yield _element(shape)
            yield "</g>"
    yield "</svg>"


def _element(shape: Shape) -> str:
    match shape:
        case Area(rings, fill, opacity, stroke):
            data = "".join(_path_data(ring) + "Z" for ring in rings)
            edge = f' stroke="{_hex(stroke)}" stroke-width="0.8"' if stroke else ""
            return (
                f'<path d="{data}" fill="{_hex(fill)}" fill-rule="evenodd"'
                f"{_opacity(opacity)}{edge}/>"
            )
        case Strokes(lines, colour, width, opacity, dash):
            data = "".join(_path_data(line) for line in lines)
            dashes = f' stroke-dasharray="{dash[0]:g} {dash[1]:g}"' if dash else ""
            return (
                f'<path d="{data}" fill="none" stroke="{_hex(colour)}"'
                f' stroke-width="{width:.4g}"{_opacity(opacity)}{dashes}/>'
            )
        case DiscShape(x, y, radius, disc_fill, stroke, width, opacity, motion):
            edge = f' stroke="{_hex(stroke)}" stroke-width="{width:.4g}"' if stroke else ""
            inside = _hex(disc_fill) if disc_fill else "none"
            return (
                f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius:.2f}" fill="{inside}"'
                f"{edge}{_opacity(opacity)}{_moving(motion, x, y) if motion else '/>'}"
            )
        case Label():
            return _text(shape)
        case Photo():
            return _photo(shape)


def _moving(motion: Motion, x: float, y: float) -> str:
    """End of a circle at (x, y) that moves (SMIL), and waits in its last place."""
    values = [f"{a:.1f},{b:.1f}" for a, b in (motion.places - (x, y)).tolist()]
    times = ["0", *(f"{share:.5f}" for share in motion.shares[1:].tolist())]
    placed, timed = ";".join([*values, values[-1]]), ";".join([*times, "1"])
    return (
        '><animateTransform attributeName="transform" type="translate"'
        f' dur="{motion.film_s:.3f}s" repeatCount="indefinite" calcMode="linear"'
        f' values="{placed}" keyTimes="{timed}"/></circle>'
    )


def _photo(photo: Photo) -> str:
    import cv2

    data = base64.b64encode(cv2.imencode(".png", photo.pixels)[1].tobytes()).decode("ascii")
    return (
        f'<image x="{photo.x:.2f}" y="{photo.y:.2f}" width="{photo.width:.2f}"'
        f' height="{photo.height:.2f}" preserveAspectRatio="none"'
        f' style="image-rendering:pixelated" href="data:image/png;base64,{data}"/>'
    )


def _text(label: Label) -> str:
    weight = ' font-weight="600"' if label.bold else ""
    halo = f' stroke="{_hex(PAGE)}" stroke-width="3.5" paint-order="stroke"' if label.halo else ""
    anchor = f' text-anchor="{label.anchor}"' if label.anchor != "start" else ""
    return (
        f'<text x="{label.x:.2f}" y="{label.y:.2f}" font-size="{label.size:g}"'
        f' fill="{_hex(label.colour)}"{weight}{anchor}{halo}>{escape(label.text)}</text>'
    )


def _path_data(points: FloatArray) -> str:
    return "M" + "L".join(f"{x:.2f},{y:.2f}" for x, y in points.tolist())


def _opacity(opacity: float) -> str:
    return "" if opacity >= 1.0 else f' opacity="{opacity:.3g}"'


def _hex(colour: Colour) -> str:
    r, g, b = colour
    return f"#{r:02x}{g:02x}{b:02x}"
