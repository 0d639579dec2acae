"""What looks wrong with a rig folder beside its recordings: `ballscrew check`.

In the order to read them: guesses, doubts, doubt, signals, order, drive, growth.
"""
