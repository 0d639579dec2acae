"""Terms into a thermal network, and that into one tick: mesh, sound, check, assemble, discretise, regime, forcing."""
