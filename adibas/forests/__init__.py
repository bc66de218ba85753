"""Decision forests on depth images: train, predict, keep in a file."""
