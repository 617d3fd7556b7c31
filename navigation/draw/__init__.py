"""Pictures of a scene, its roadmap, path and driven tracks, as SVG or PNG.

- ``picture.py`` collects the contents of a picture and saves it.
- ``layers.py`` draws the plot from the floor up, with ``driven.py`` and ``robot_marks.py`` for
  robots and ``numbers.py`` for labels; ``places.py`` keeps words off lines.
- ``zones.py`` draws zones, ``outlines.py`` turns borders into lines.
- ``legend.py`` draws the legend and the scale beside the plot.
- ``shapes.py`` holds the flat shapes and colours; ``svg.py`` and ``png.py`` write them down.
- ``overlay.py`` draws the records of a scene over the picture they were found in.
"""

from navigation.draw.driven import DrawnRobot
from navigation.draw.layers import OtherRobot
from navigation.draw.picture import DrawError, draw_png, draw_svg, save_picture

__all__ = ["DrawError", "DrawnRobot", "OtherRobot", "draw_png", "draw_svg", "save_picture"]
