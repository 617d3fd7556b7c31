"""Quality of a camera's pictures, measured for some seconds.

`watching` gathers the data of each picture. `timing` then judges arrival times, `brightness` noise,
flicker and clipping, and `focus` the sharpness of edges, part by part.
"""

from vision.quality.watching import Quality, Watching

__all__ = ["Quality", "Watching"]
