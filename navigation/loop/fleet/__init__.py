"""The control loop of several robots: one camera and one planner, a pilot and a link for each.

`seat` is what one robot needs of it, the same parts as with one robot; `fleet_planner` answers for
all of them; `fleet_daemon` is the loop: newest frame -> eye -> every pilot -> coordinator -> orders
to the planner and every link. `people` takes orders, for all robots or one; `fleet_state` is what
the loop tells of itself after each cycle.
"""
