"""Symptoms of a line without a link, as a sentence for the person who fixes it."""

from __future__ import annotations

from typing import Final

from firmware_protocol.wire.framing import VERSION, ParserCounters

TAKEN_OVER: Final = "another host has taken the robot over"


def why_refused(major: int, schema: int, ours: int) -> str | None:
    """Reason why a robot of this version and schema is unusable, if so."""
    if major == VERSION and schema == ours:
        return None
    older = "the robot's firmware or this program, whichever is older"
    if major != VERSION:
        older = "the robot's firmware" if major < VERSION else "this program"
    return (
        f"the robot speaks protocol {major} with schema {schema:#010x}, "
        f"this program {VERSION} with {ours:#010x}: update {older}"
    )


def why_silent(count: ParserCounters, no_byte_s: float | None) -> str:
    """Most likely reason for silence; ``no_byte_s``: time without any byte, None if some arrive."""
    if no_byte_s is not None:
        return (
            f"no byte has come from the robot for {no_byte_s:.1f} s: "
            "is it switched on, the cable plugged in, and the wire from it (RX) whole?"
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
    return (
        "a robot was heard, but it does not answer: check the wire from the computer to the robot "
        "(TX), and whether another program has the robot"
    )
