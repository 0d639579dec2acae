"""The filter tuning tests: what a change of the model did to the filter, on recordings. See docs/tuning.md."""
