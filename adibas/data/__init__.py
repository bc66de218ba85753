"""The vocabulary: frozen types that cross the border between two stages."""
