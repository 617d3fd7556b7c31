"""Pictures of a scene and what was made of it, as SVG or PNG; and records over their picture."""

from navigation.draw.driven import DrawnRobot
from navigation.draw.layers import OtherRobot
from navigation.draw.picture import DrawError, draw_png, draw_svg, save_picture

__all__ = ["DrawError", "DrawnRobot", "OtherRobot", "draw_png", "draw_svg", "save_picture"]
