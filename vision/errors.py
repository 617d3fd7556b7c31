"""What is wrong with what Global Vision was given: a picture, or an option that goes with it."""

from __future__ import annotations


class PictureError(ValueError):
    """A picture, or an option for it, cannot be used; the message says what is wrong with it."""
