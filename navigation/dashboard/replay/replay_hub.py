"""The hub of a recording's page: all viewers see the same moment, and steer it.

A jump changes the past: log, track and charts are rebuilt, and every page is greeted again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from navigation.dashboard.chronicles import Chronicles
from navigation.dashboard.hub import Hub
from navigation.dashboard.messages.chronicle import LOG_LINES, SAMPLE_EVERY_S, SAMPLES
from navigation.dashboard.replay.player import SPEEDS, Player
from navigation.dashboard.replay.replayed_run import ReplayedRun
from navigation.loop.run_state import RunState
from navigation.shared.outside import finite_number, in_short

TRACK_EVERY_S: Final = 0.2
"""Time between places of a past track, well below where it breaks (`UNSEEN_S`)."""
TRACK_PLACES: Final = 12_000
"""Places of all tracks together, at most: half a second's work."""


class ReplayHub(Hub):
    """A hub around a `ReplayedRun`."""

    def __init__(self, run: ReplayedRun, *, clock: Callable[[], float]) -> None:
        super().__init__(run, clock=clock, wall_clock=run.wall_clock)
        self.run_shown = run
        recording = run.tape.recording
        self.hello["replay"] = {
            "file": recording.path.name,
            "version": recording.version,
            "cut": recording.cut,
            "duration_s": self._player.duration_s,
            "began_s": run.tape.begin_s + run.tape.wall_offset_s,
            "speeds": list(SPEEDS),
        }
        self._jumps = self._player.jumps

    @property
    def _player(self) -> Player:
        return self.run_shown.player

    def look(self, now_s: float) -> None:
        """Look as any hub; after a jump rebuild the past first."""
        if self._player.jumps != self._jumps:
            self._jumps = self._player.jumps
            self._begin_again(self._player.place_s(now_s))
        super().look(now_s)

    def steer(self, message: Mapping[str, Any]) -> str | None:
        """Steer with ``{"do": "play"|"pause"|"seek"|"step"|"speed", "value": N}``.

        ``seek`` goes to a place, ``step`` goes that far from the present one; seconds. Returns the
        reason to refuse, or None.
        """
        now_s, player = self.clock(), self._player
        value = finite_number(message.get("value"))
        match message.get("do"):
            case "play":
                player.play(now_s)
            case "pause":
                player.pause(now_s)
            case "seek" if value is not None:
                player.seek(now_s, value)
            case "step" if value is not None:
                player.seek(now_s, player.place_s(now_s) + value)
            case "speed" if value in SPEEDS:
                player.set_speed(now_s, value)
            case "seek" | "step" | "speed":
                return f"value {in_short(message.get('value'))}: is no such place or speed"
            case other:
                return f"do {in_short(other)}: must be play, pause, seek, step or speed"
        self.look(now_s)
        self.tell_now()
        return None

    def _begin_again(self, place_s: float) -> None:
        self.chronicles = Chronicles(self.daemon.config)
        self.chronicle = self.chronicles.all
        run = self.run_shown
        tape, now_s = run.tape, run.tape.begin_s + place_s
        track_s = TRACK_EVERY_S * TRACK_PLACES / max(1, len(self.chronicles.each))
        tracked = tape.seen_between(now_s - track_s, now_s, TRACK_EVERY_S)
        for time_s in sorted({*tape.told_until(now_s, LOG_LINES), *tracked}):
            at_s = time_s - tape.begin_s
            charted = time_s >= now_s - SAMPLES * SAMPLE_EVERY_S
            state, wall_s = run.at(at_s, in_short=not charted), time_s + tape.wall_offset_s
            self.chronicles.see(state, run.camera_at(at_s), wall_s, charted=charted)
        self.epoch += 1
        self.wake()

    def _observe(self, state: RunState) -> None:
        """Observe in the run's own times: fast playing does not look like a lifted robot."""
        super()._observe(self.run_shown.at(state.time_s))
        poses = state.together.poses
        self._others.update((i, poses[i]) for i in poses if i in self._others)  # with the same age

    def _facts(self, state: RunState, now_s: float) -> dict[str, Any]:
        player = self._player
        return {
            **super()._facts(state, now_s),
            "replay": {
                "place_s": round(player.place_s(now_s), 3),
                "playing": player.playing and player.place_s(now_s) < player.duration_s,
                "speed": player.speed,
            },
        }
