"""Parameters and noise levels from recordings."""
