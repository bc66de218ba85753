"""Recordings on disk: MCAP, .oni and TUM RGB-D folders."""
