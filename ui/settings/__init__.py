"""Preferences, protection of the store, this computer, and what the program is."""
