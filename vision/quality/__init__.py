"""Quality of a camera's pictures, measured for some seconds.

`watching` gathers what is needed of each picture; `timing` judges when they came, `light` noise,
flicker and clipping, `focus` how sharp edges are, and where. Nothing here knows what the camera
could do or was asked for.
"""

from vision.quality.watching import Quality, Watching

__all__ = ["Quality", "Watching"]
