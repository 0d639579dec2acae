"""What is estimated, how a run begins, and how a person reads it: state, run, prior, gate, open_loop, view, report."""
