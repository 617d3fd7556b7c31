from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.host.line.clock_sync import WRAP_US, ClockEstimate
from firmware_protocol.wire.link import (
    RTO_MAX_S,
    RTO_MIN_S,
    Arrival,
    ReceiveSequence,
    RttEstimate,
    SendWindow,
    is_before,
)


def test_sequence_order_is_that_of_the_circle() -> None:
    assert is_before(250, 3)
    assert not is_before(3, 250)
    assert not is_before(7, 7)


@given(st.integers(0, 255), st.integers(1, 127))
def test_what_was_taken_is_a_duplicate_and_what_is_ahead_a_gap(start: int, step: int) -> None:
    receiver = ReceiveSequence()
    receiver.expected = start
    assert receiver.judge((start - step) % 256) is Arrival.DUPLICATE
    assert receiver.judge((start + step) % 256) is Arrival.GAP
    assert receiver.judge(start) is Arrival.NEXT


def test_window_holds_two_full_frames_and_no_third() -> None:
    window = SendWindow(248)
    for _ in range(2):
        assert window.room_for(106)
        window.add(0x10, bytes(106))
    assert not window.room_for(1)
    assert window.bytes_pending == 242


def test_one_frame_always_fits_however_small_the_window() -> None:
    window = SendWindow(10)
    assert window.room_for(106)
    window.add(0x10, bytes(106))
    assert not window.room_for(0)


def test_a_complaint_sends_all_again_once_a_round_trip() -> None:
    window = SendWindow(248)
    for _ in range(2):
        window.add(1, b"")
    assert [window.next_frame(0.0), window.next_frame(0.0)] != [None, None]
    window.complained(0.01)
    first = window.next_frame(0.01)
    assert first is not None
    assert (first.sequence, first.sent_again) == (0, True)
    window.complained(0.011)
    second = window.next_frame(0.011)
    assert second is not None
    assert second.sequence == 1


def test_timeout_backs_off_and_an_answer_ends_that() -> None:
    window = SendWindow(248)
    window.add(1, b"")
    window.next_frame(0.0)
    window.tick(0.099)
    assert not window.has_unsent()
    window.tick(0.1)
    assert window.has_unsent()
    assert window.rtt.timeout_s == 0.2
    window.rtt.add(0.01)
    assert window.rtt.timeout_s == 0.03


def test_a_frame_sent_twice_gives_no_round_trip_time() -> None:
    window = SendWindow(248)
    window.add(1, b"")
    window.next_frame(0.0)
    window.tick(1.0)
    window.next_frame(1.0)
    assert window.acknowledge(1, 1.001) == 1
    assert window.rtt.samples == 0


def test_an_acknowledgement_for_nothing_in_flight_changes_nothing() -> None:
    window = SendWindow(248)
    window.add(1, b"")
    assert window.acknowledge(1, 0.0) == 0
    window.next_frame(0.0)
    assert window.acknowledge(0, 0.0) == 0
    assert window.acknowledge(200, 0.0) == 0
    assert window.acknowledge(1, 0.0) == 1
    assert window.idle


@given(st.lists(st.floats(0.0, 10.0), max_size=40), st.integers(0, 20))
def test_timeout_stays_within_its_limits(samples: list[float], backs: int) -> None:
    rtt = RttEstimate()
    for sample in samples:
        rtt.add(sample)
    for _ in range(backs):
        rtt.back_off()
    assert RTO_MIN_S <= rtt.timeout_s <= RTO_MAX_S


@given(st.lists(st.sampled_from(["send", "lose", "ack", "wait", "complain"]), max_size=200))
def test_go_back_n_delivers_everything_once_and_in_order(script: list[str]) -> None:
    """An independent receiver takes what the window sends over a line that loses."""
    window, receiver = SendWindow(100), ReceiveSequence()
    given_, taken, now_s = 0, [], 0.0
    for step in [*script, *["send", "ack", "wait"] * 400]:
        now_s += 0.01
        while given_ < 300 and window.room_for(10):
            window.add(0x10, given_.to_bytes(10, "little"))
            given_ += 1
        if step in ("send", "lose"):
            frame = window.next_frame(now_s)
            if frame and step == "send" and receiver.judge(frame.sequence) is Arrival.NEXT:
                receiver.take()
                taken.append(int.from_bytes(frame.payload, "little"))
        elif step == "ack":
            window.acknowledge(receiver.expected, now_s)
        elif step == "complain":
            window.complained(now_s)
        else:
            now_s += 1.0
            window.tick(now_s)
        assert window.bytes_pending <= 100
    assert taken == list(range(len(taken)))
    assert len(taken) >= 300


def exchange(
    clock: ClockEstimate, now_s: float, offset_s: float, there: float, back: float
) -> None:
    received_us = int((now_s + there + offset_s) * 1e6) % WRAP_US
    clock.add(now_s, received_us, (received_us + 100) % WRAP_US, now_s + there + 100e-6 + back)


def test_clock_offset_is_found_among_slow_exchanges() -> None:
    clock = ClockEstimate()
    for i in range(20):
        slow = 0.05 if i % 3 == 1 else 0.0
        exchange(clock, float(i), 123.4, 0.002 + slow, 0.002)
    assert abs(clock.offset_s(20.0) - 123.4) < 1e-5


def test_clock_drift_is_found() -> None:
    clock = ClockEstimate()
    for i in range(30):
        exchange(clock, float(i), 5.0 + 100e-6 * i, 0.001, 0.001)
    assert abs(clock.drift - 100e-6) < 5e-6
    assert abs(clock.offset_s(40.0) - (5.0 + 100e-6 * 40)) < 1e-4


def test_the_robots_clock_may_wrap() -> None:
    clock = ClockEstimate()
    offset_s = WRAP_US / 1e6 - 5.0
    for i in range(10):
        exchange(clock, float(i), offset_s, 0.001, 0.001)
    assert abs(clock.offset_s(9.0) - offset_s) < 1e-5
