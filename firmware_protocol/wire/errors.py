"""Errors by origin: ours (``LocalError``) or the wire's (``RemoteError``)."""

from __future__ import annotations


class LocalError(ValueError):
    """A request that the wire cannot carry or the state rules out."""


class RemoteError(ValueError):
    """A whole message from the other end that makes no sense."""
