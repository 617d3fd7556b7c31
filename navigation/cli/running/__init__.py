"""Commands that drive, or talk to what drives: run, orders, robot, replay, dashboard, sweep."""
