"""The send window: go-back-N, the window's size, and its timeout."""

from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.host.line.send_window import (
    RTO_MAX_S,
    RTO_MIN_S,
    SEQUENCE_MODULUS,
    RttEstimate,
    SendWindow,
)


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
    window, expected = SendWindow(100), 0
    given_, taken, now_s = 0, [], 0.0
    for step in [*script, *["send", "ack", "wait"] * 400]:
        now_s += 0.01
        while given_ < 300 and window.room_for(10):
            window.add(0x10, given_.to_bytes(10, "little"))
            given_ += 1
        if step in ("send", "lose"):
            frame = window.next_frame(now_s)
            if frame and step == "send" and frame.sequence == expected:
                expected = (expected + 1) % SEQUENCE_MODULUS
                taken.append(int.from_bytes(frame.payload, "little"))
        elif step == "ack":
            window.acknowledge(expected, now_s)
        elif step == "complain":
            window.complained(now_s)
        else:
            now_s += 1.0
            window.tick(now_s)
        assert window.bytes_pending <= 100
    assert taken == list(range(len(taken)))
    assert len(taken) >= 300
