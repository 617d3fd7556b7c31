"""Every fault of the serial link as a scenario in virtual time, judged by the executed chain.

A scenario takes a seed and returns what happened in a word, or raises AssertionError. The
judge does not trust the robot's counters alone: ``Witness`` notes every record that the robot
executes, in order, and every moment in which it moves.
"""

from __future__ import annotations

from collections.abc import Callable

from tests.support.wire.fault_witness import robot_maker
from tests.support.wire.host_faults import (
    camera_goes_blind,
    control_loop_hangs,
    estop_after_a_truncated_frame,
    estop_on_a_bad_line,
    estop_under_full_load,
    host_killed,
    paused,
    permit_withdrawn,
    replaced_while_driving,
    silence_disarms,
    start_without_a_lease,
)
from tests.support.wire.hostile_scenarios import HOSTILE
from tests.support.wire.line_faults import (
    cable_pulled,
    frames_of_nonsense,
    last_acknowledgement_lost,
    late_frames_of_an_old_session,
    line_echoes,
    rough,
    schema_mismatch,
    second_host,
    sequence_wraps,
    wrong_baud_rate,
)
from tests.support.wire.robot_faults import (
    brown_out_loop,
    clocks_drift,
    clocks_wrap,
    processor_freezes,
    processor_resets,
    reset_between_accept_and_ack,
    reset_on_open,
    short_freeze,
)

__all__ = ["SCENARIOS", "robot_maker"]


SCENARIOS: dict[str, Callable[[int], str]] = {
    "no fault": rough(""),
    "byte loss 0.1 %": rough("drop=0.001"),
    "byte loss 1 %": rough("drop=0.01"),
    "bit flips 0.1 % of bytes": rough("flip=0.001"),
    "noise bytes 0.1 %": rough("noise=0.001"),
    "spans lost in 3 % of frames": rough("span=0.03"),
    "10 % of frames doubled": rough("dup=0.1"),
    "10 % of frames swapped": rough("swap=0.1"),
    "mixed": rough("drop=0.001,flip=0.0005,noise=0.0005,span=0.005,dup=0.02,swap=0.02"),
    "stalls of 0.2 s, then bursts": rough("stall=0.2@1"),
    "stalls of 0.8 s, then bursts": rough("stall=0.8@4"),
    "cable pulled and plugged in": cable_pulled,
    "processor frozen 0.1 s": short_freeze,
    "processor frozen, watchdog": processor_freezes,
    "processor reset": processor_resets,
    "reset between accept and acknowledgement": reset_between_accept_and_ack,
    "last acknowledgement lost": last_acknowledgement_lost,
    "late frames of an old session": late_frames_of_an_old_session,
    "sequence numbers wrap": sequence_wraps,
    "clocks wrap": clocks_wrap,
    "clocks drift 150 ppm": clocks_drift,
    "host killed three times": host_killed,
    "second host on the line": second_host,
    "wrong baud rate": wrong_baud_rate,
    "line echoes": line_echoes,
    "reset on open, boot banner": reset_on_open,
    "brown-out loop": brown_out_loop,
    "schema mismatch": schema_mismatch,
    "nonsense in whole frames": frames_of_nonsense,
    "e-stop, full queue and window": estop_under_full_load,
    "e-stop after a truncated frame": estop_after_a_truncated_frame,
    "e-stop on a bad line": estop_on_a_bad_line,
    "control loop hangs, poses flow": control_loop_hangs,
    "silence disarms": silence_disarms,
    "camera goes blind": camera_goes_blind,
    "permit withdrawn": permit_withdrawn,
    "paused and started again": paused,
    "start without a lease": start_without_a_lease,
    "mission replaced while driving": replaced_while_driving,
    **HOSTILE,
}
