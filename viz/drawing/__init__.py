"""What views are drawn with.

In the order to read them: paths, file, views, scale, axes, frame, columns, series, profile, screw, residuals, events.
"""
