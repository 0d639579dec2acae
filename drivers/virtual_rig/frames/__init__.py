"""What goes over the bus and into files: frames, recording, player."""
