"""The surface of the body: the back and its spine, views joined into one surface, slices."""
