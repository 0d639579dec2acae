"""Views of a tuning: tuning, tuned, autocorrelation, layout."""
