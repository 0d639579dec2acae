"""Which effect is missing."""
