"""Where the person is in a depth image."""
