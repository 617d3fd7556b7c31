"""What a line without a link looks like, as a sentence for whoever has to mend it."""

from __future__ import annotations

from firmware_protocol.framing import VERSION, ParserCounters


def why_silent(count: ParserCounters, no_byte_s: float | None) -> str:
    """The most likely reason; ``no_byte_s``: for how long no byte has come, None where some do."""
    if no_byte_s is not None:
        return (
            f"no byte has come from the robot for {no_byte_s:.1f} s: "
            "is it switched on and the cable plugged in?"
        )
    if count.echoes and not count.frames:
        return "the line echoes what is sent: are its two wires connected to each other?"
    if count.version_errors and not count.frames:
        return f"the robot speaks another protocol version than {VERSION}"
    if not count.frames:
        return (
            f"{count.bytes} bytes came but no whole frame "
            f"({count.faults} damaged): is the baud rate right?"
        )
    return "a robot was heard, but it does not answer"
