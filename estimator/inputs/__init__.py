"""The inputs u over time, and what a run does: it moves, starts, rests.

In the order to read them: inputs, balls, gate, motion, start, untold, phase, follower, reach, moved.
"""
