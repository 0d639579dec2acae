"""The filter's twin for whole recordings, compiled."""
