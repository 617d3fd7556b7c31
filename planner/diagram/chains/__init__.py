"""The chains: traced along valid edges, bent onto bisectors, kept where nothing has changed."""
