"""A plant, a row a rig, over weeks: plant."""
