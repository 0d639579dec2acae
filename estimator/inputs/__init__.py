"""The inputs u over time, and what a run does: it moves, starts, rests: inputs, motion, start, phase, follower."""
