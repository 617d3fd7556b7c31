"""Several robots driven together: their promises, and how far each may drive along its own.

- `request` has the planner's requests and answers, a promise being a path with gates at shared
  places; `asking` makes a request.
- `planning` promises paths to all robots, `joining` adds some while others drive, `rounding`
  smooths corners.
- `releases` says how far each robot may drive, `orders` which robots wait or hold, `gate_waits`
  which wait in vain.
- `members` has what is known of each robot, and the places of those that take no part; `refusals`
  remembers failed requests.
- `runaways` finds robots that run away, and `giving_way` moves the others aside.
- `coordinator` decides with all of these, once a cycle.

Nothing here opens anything or reads a clock.
"""
