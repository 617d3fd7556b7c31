"""The configuration on the page: shown, checked while it is typed, saved with a way back."""
