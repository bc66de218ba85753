"""Builds the manual that the window opens: pages of `docs/` with figures, offline."""
