"""Terms into a thermal network, and the network into one tick: mesh, assemble, discretise, regime, forcing, check."""
