"""What heats, moves and grows: heat, flows, screw, nut, bearings, air, heaters, drawn, weather, motion, geometry,
and what is planted."""
