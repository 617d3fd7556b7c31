"""Several robots that are driven together: what each is promised, and what it may drive of it.

`request` asks for a plan of all who want to move; `planning` makes promises of the fleet's plan: a
path for each with the gates at places that it shares. `releases` says how far each may drive, for
whom it waits and why; `coordinator` decides when all stand still and are planned again, and which
places a robot that is lost or stopped keeps. Decisions only: nothing here opens anything or reads
a clock.
"""
