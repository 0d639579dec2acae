"""Physics and statistics of a heated screw: no clock, thread, plot or print in here."""
