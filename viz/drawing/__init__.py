"""What views are drawn with.

In the order to read them: paths, scale, entity, file, views, frames, series, profile, screw, body, bars, residuals.
"""
