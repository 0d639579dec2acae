"""What is estimated, how a run begins, how it is read: state, run, warmth, prior, gate, open_loop, view, report.

And what parameters that are off make of it: tangent, moves, own, doubt.
"""
