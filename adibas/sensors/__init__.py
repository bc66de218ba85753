"""Depth cameras behind one protocol."""
