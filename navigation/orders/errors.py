"""Errors of orders that cannot be given or taken."""


class ControlError(ValueError):
    """Error: an order cannot be given or taken."""


class NoDaemonError(ControlError):
    """Error: certainly no daemon runs."""
