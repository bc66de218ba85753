"""Mathematics of cameras and of points in space, on arrays."""
