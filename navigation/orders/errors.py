"""Errors of orders that cannot be given or taken."""


class ControlError(ValueError):
    """An order that cannot be given or taken; the message says why."""


class NoDaemonError(ControlError):
    """An order without a recipient: certainly no daemon runs."""
