"""What is estimated, how a run begins, and how a person reads it."""
