"""Navigation Control: configuration, the daemon, the simulator and the command line."""
