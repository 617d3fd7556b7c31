"""Error for input that Global Vision cannot use."""

from __future__ import annotations


class PictureError(ValueError):
    """A picture or an option that cannot be used; the message gives the reason."""
