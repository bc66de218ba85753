"""What is around a pixel of a person: a network that corrects a forest's probabilities by it."""
