"""The scene as text: the paper's records (section 3.3), one a line, without loss.

The plain format
    P (x,y)                     a point
    S (x0,y0) (x1,y1)           a segment
    C (xc,yc) r                 a circle
    A N (x1,y1)...(xn,yn)       an open chain of N vertices
    L N (x1,y1)...(xn,yn)       a generalized polygon of N vertices, closed from last to first
``#`` begins a comment. Spaces, tabs and commas between coordinates are equivalent.

Extensions are comments to other readers. They count only if the first line that is not blank is
``#@ clearway.scene/1``.
    #@ units px|m|cells
    #@ bounds given|derived x_min y_min x_max y_max
    #@ size width height            of the picture, in pixels, or of the grid, in cells
    #@ border_pixels n
    #@ binarisation {...}           JSON, like the next two
    #@ timings_ms {...}
    #@ remark "..."
    #@ object id                    the records below belong to this object
    #@ hole                         the records below are the border of a hole of the object
    #@ arc k xc yc r cw|ccw         edge k (from 1) of the record above is this arc
    #@ residual_px d                distance of the record above from its pixels

A file without extensions is in px; each record is an object of its own; polygons are reoriented
clockwise as seen on the screen. Its bounds are the records' bounding box, grown by its diagonal on
every side. Numbers are written as Python's shortest ``repr``.
"""

from __future__ import annotations

from planner.formats.line_scanner import Scanner
from planner.formats.scene_text_reader import HEADER, SceneReader
from planner.formats.scene_text_writer import scene_lines
from planner.scene import Scene
from planner.shared.arguments import of_kind

__all__ = ["HEADER", "read_scene_text", "write_scene_text"]


def read_scene_text(text: str, name: str = "<text>") -> Scene:
    """Read the scene in ``text``; ``name`` is the file's name in errors.

    Raises :class:`SceneError` ("name:line:column: what") on unknown records, wrong counts, numbers
    beyond ``MAX_COORDINATE``, radii <= 0, and trailing characters. O(length).
    """
    of_kind("text", text, str)
    reader = SceneReader(name)
    for number, line in enumerate(text.removeprefix("\ufeff").splitlines(), start=1):
        reader.take_line(Scanner(name, number, line))
    return reader.finish()


def write_scene_text(scene: Scene) -> str:
    """Write the scene with all extensions; ``read_scene_text`` returns an equal scene.

    Raises :class:`SceneError` on edges that do not connect, numbers that are not finite, and arcs
    off their circles.
    """
    of_kind("scene", scene, Scene)
    return "\n".join(scene_lines(scene)) + "\n"
