"""Depth onto colour."""
