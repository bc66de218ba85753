"""Behaviour: activity from joints, what observers coded, and how far they agree."""
