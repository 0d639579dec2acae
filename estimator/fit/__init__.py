"""Parameters and noise levels from recordings: fit, tune, open_loop_fit, misfits, bodies, untold, calibration,
likelihood, noise, unseen."""
