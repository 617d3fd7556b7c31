"""Errors by origin: ours (``LocalError``) or the wire's (``RemoteError``)."""

from __future__ import annotations


class LocalError(ValueError):
    """A request of this program that the wire cannot carry or the state rules out."""


class RemoteError(ValueError):
    """A message from the other end that is whole but makes no sense; the text gives the reason."""
