"""Views of a tuning: tuning."""
