"""Terms into a thermal network, and one tick: mesh, growth, sound, check, assemble, discretise, regime,
unknown, forcing."""
