"""Terms into a thermal network, and one tick: mesh, sound, check, assemble, discretise, regime, unknown, forcing."""
