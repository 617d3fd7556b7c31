"""The pictures' colours as the page's style.

`DAY` and `NIGHT` are the page's own surfaces and inks; drawings in the arena have the colours of
`navigation.draw.shapes` in both.
"""

from __future__ import annotations

from collections.abc import Mapping

from navigation.draw import shapes
from navigation.draw.shapes import ROBOTS, Colour, ramp_colour
from navigation.draw.zones import COLOURS as ZONES

ARENA: Mapping[str, Colour] = {
    "obstacle": shapes.OBSTACLE,
    "obstacle-edge": shapes.OBSTACLE_EDGE,
    "floor": shapes.FLOOR,
    "frame": shapes.FRAME,
    "path": shapes.PATH,
    "preview": shapes.GOAL,
    "track": shapes.TRACK,
    "narrowest": shapes.BOTTLENECK,
    "start": shapes.START,
    "goal": shapes.GOAL,
    "halo": shapes.PAGE,
}
DAY: Mapping[str, Colour] = {
    "page": (244, 245, 246),
    "card": shapes.PAGE,
    "line": (214, 218, 223),
    "control-line": (128, 134, 142),
    "ink": shapes.INK,
    "faint": (88, 94, 102),
    "accent": (22, 84, 160),
    "on-accent": (255, 255, 255),
    "good": (10, 110, 56),
    "warn": (138, 76, 0),
    "bad": (176, 18, 44),
    "good-tint": (226, 243, 233),
    "warn-tint": (252, 240, 220),
    "bad-tint": (253, 229, 232),
    "calm-tint": (233, 237, 243),
    "stop": (196, 16, 34),
    "stop-press": (150, 8, 24),
    "on-stop": (255, 255, 255),
}
NIGHT: Mapping[str, Colour] = {
    "page": (18, 20, 24),
    "card": (29, 32, 38),
    "line": (56, 61, 69),
    "control-line": (128, 134, 144),
    "ink": (234, 237, 241),
    "faint": (168, 175, 185),
    "accent": (130, 184, 250),
    "on-accent": (12, 22, 36),
    "good": (102, 208, 146),
    "warn": (244, 184, 92),
    "bad": (255, 140, 148),
    "good-tint": (22, 52, 36),
    "warn-tint": (58, 42, 14),
    "bad-tint": (72, 22, 28),
    "calm-tint": (38, 44, 54),
    "stop": (214, 24, 42),
    "stop-press": (168, 12, 28),
    "on-stop": (255, 255, 255),
}


def stylesheet() -> str:
    """Colours as CSS variables; light, or dark if the system or the page asks for it."""
    zones = {f"zone-{kind.replace('_', '-')}": colour for kind, colour in ZONES.items()}
    robots = {f"robot-{number}": colour for number, colour in enumerate(ROBOTS)}
    ramp = {f"ramp-{step}": ramp_colour(step) for step in range(shapes.RAMP_STEPS)}
    return "\n".join(
        [
            ":root {",
            "  color-scheme: light;",
            *_variables({**ARENA, **zones, **robots, **ramp, **DAY}),
            "}",
            "@media (prefers-color-scheme: dark) {",
            "  :root:not([data-theme='light']) {",
            "    color-scheme: dark;",
            *_variables(NIGHT),
            "  }",
            "}",
            ":root[data-theme='dark'] {",
            "  color-scheme: dark;",
            *_variables(NIGHT),
            "}",
            "",
        ]
    )


def _variables(colours: Mapping[str, Colour]) -> list[str]:
    return [f"    --{name}: rgb({r} {g} {b});" for name, (r, g, b) in colours.items()]
