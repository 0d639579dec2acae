"""What goes over the bus and into files."""
