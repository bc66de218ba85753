"""The window: thin Qt screens over the core."""
