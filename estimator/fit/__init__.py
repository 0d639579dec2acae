"""Parameters and noise levels from recordings: fit, tune, open_loop_fit, prior, untold, likelihood, noise."""
