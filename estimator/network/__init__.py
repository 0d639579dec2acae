"""Terms into a thermal network, and the network into one tick."""
