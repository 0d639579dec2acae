"""What heats, moves and grows."""
