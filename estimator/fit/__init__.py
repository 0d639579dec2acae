"""Parameters and noise levels from recordings: fit, tune, open_loop_fit, curvature, misfits, bodies, untold,
calibration, likelihood, noise, unseen."""
