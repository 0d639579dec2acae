"""What every effect must pass."""
