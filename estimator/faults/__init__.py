"""Which channels are broken, by what they read against the model and each other.

In the order to read them: fault, jumps, standstill, machine, outlier, neighbours, suspects, recovery, judge, travel,
use, sentences.
"""
