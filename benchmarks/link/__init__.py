"""The serial link's speed, beside MAVLink's upload of missions: ``python -m benchmarks.link``."""
