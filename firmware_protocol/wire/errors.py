"""Whose fault it is: ours (``LocalError``) or the wire's (``RemoteError``)."""

from __future__ import annotations


class LocalError(ValueError):
    """This program asked for what the wire cannot carry or the state rules out; it says what."""


class RemoteError(ValueError):
    """The other end sent something that is whole but makes no sense; the message says what."""
