"""From a path to timed waypoints: rounded corners, stops, speeds."""
