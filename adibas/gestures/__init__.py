"""Gestures: from joints over time to what was done, from when to when."""
