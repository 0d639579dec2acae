"""The inputs u over time, and what a run does: it moves, starts, rests."""
