"""Parameters and noise levels from recordings: fit, tune, open_loop_fit, untold, likelihood, noise."""
