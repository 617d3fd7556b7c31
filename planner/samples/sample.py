"""The samples by name: three pictures and a map of rooms.

Pictures are for ``vision.extract``, the map is for ``load_scene``.
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType

from planner.scene import SceneError

SAMPLES = MappingProxyType(
    {
        "arena": ("arena.png",),
        "photograph": ("photograph.jpg",),
        "maze": ("maze.png",),
        "rooms": ("rooms.yaml", "rooms.pgm"),
    }
)
"""The files of each sample; the first is the one to open."""


def sample(name: str) -> Path:
    """Path of a sample's file, which is read-only.

    ``arena``, ``photograph`` and ``maze`` are pictures of 640 x 480 pixels, of dark obstacles on a
    light floor: a clean drawing; one with uneven light, soft shadows, blur and noise; corridors of
    34 pixels. ``rooms`` is a ROS map, a YAML file with its picture beside it, 8 m by 5 m.

    Raises :class:`SceneError` for another name.
    """
    return sample_files(name)[0]


def sample_files(name: str) -> tuple[Path, ...]:
    """All files of a sample, the one to open first."""
    if not isinstance(name, str) or name not in SAMPLES:
        raise SceneError(f"no sample {name!r}: must be one of {', '.join(SAMPLES)}")
    return tuple(Path(__file__).with_name(file) for file in SAMPLES[name])
