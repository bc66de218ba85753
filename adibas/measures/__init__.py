"""Distances and angles between markers, with their intervals."""
