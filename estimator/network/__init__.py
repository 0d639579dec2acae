"""Terms into a thermal network, and one tick: mesh, growth, sound, check, layout, assemble, discretise, regime,
unknown, forcing."""
