"""Two witnesses of one motion: what the camera saw, and what the wheels turned.

The robot's reports become a track of its wheels (``wheels``). The camera's poses are laid beside
it: ``latency`` finds how old the pictures are, as the shift at which both move alike;
``agreement`` finds where they part by more than both errors allow, and how far they have agreed;
``witness`` feeds both and gives one `Evidence` a cycle. What follows from it is decided by the
pilot: `navigation.mission.trust` has the rules.

Nothing here opens anything or reads a clock. Metres, radians, seconds.
"""

from navigation.witness.evidence import NO_EVIDENCE, Evidence
from navigation.witness.witness import Witness, WitnessLimits

__all__ = ["NO_EVIDENCE", "Evidence", "Witness", "WitnessLimits"]
