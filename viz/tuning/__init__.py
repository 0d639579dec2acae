"""Views of a tuning: tuning, tuned, layout."""
