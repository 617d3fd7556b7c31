"""The search for a plan: one robot after the other, all at once, and proofs of refusals.

- ``team`` defines robots and routes; ``fleet_search`` runs the stages and checks the plan.
- ``solver`` plans one robot after the other, and shortens the result.
- ``joint_search`` moves all robots at once; ``pair_proof`` proves that two can never pass.
- ``one_by_one`` moves one robot at a time between ``stations``, as in ``pebbles``.
- ``matching`` assigns rows to columns.
"""
