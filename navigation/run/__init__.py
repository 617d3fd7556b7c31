"""One run from its beginning to its report, in real time or in virtual time."""
