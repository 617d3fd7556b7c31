"""Pictures of a scene, its roadmap, path and driven tracks, as SVG or PNG.

- `picture` collects the contents of a picture and saves it.
- `layers` draws the plot from the floor up, with `driven`, `robot_marks`, `zones` and `numbers`;
  `outlines` turns borders into lines.
- `legend` draws the legend and the scale beside the plot.
- `shapes` holds the flat shapes and colours; `svg` and `png` write them down.
- `overlay` draws the records of a scene over the picture they were found in.
"""

from navigation.draw.driven import DrawnRobot
from navigation.draw.layers import OtherRobot
from navigation.draw.picture import DrawError, draw_png, draw_svg, save_picture

__all__ = ["DrawError", "DrawnRobot", "OtherRobot", "draw_png", "draw_svg", "save_picture"]
