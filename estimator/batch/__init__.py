"""The filter's twin for whole recordings, compiled.

In the order to read them: batch, system, compiled, kernels, nominal, open_loop, ahead, judged, trial, trials, replay,
coarse.
"""
