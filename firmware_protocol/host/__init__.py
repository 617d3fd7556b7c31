"""The host's end of the link: sessions, the robot's clock, uploads, orders."""
