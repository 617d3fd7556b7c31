"""The search for a plan: one robot after the other, all at once, and proofs of refusals."""
