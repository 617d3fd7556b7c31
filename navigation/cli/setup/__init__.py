"""Commands that set up a machine and an arena: init, check, doctor, devices, calibrate, marker."""
