"""The filter's twin for whole recordings, compiled.

In the order to read them: batch, system, kernels, nominal, open_loop, trial, trials, replay, coarse.
"""
