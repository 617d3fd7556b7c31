"""Orders that cannot be given or taken; the message says why."""


class ControlError(ValueError):
    """An order that cannot be given or taken; the message says why."""


class NoDaemonError(ControlError):
    """An order that nobody takes, because certainly no daemon runs."""
