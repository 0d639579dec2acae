"""What heats, moves and grows: heat, flows, screw, nut, bearings, air, heaters, weather, motion, geometry, planted."""
