"""What a person sees: a recording and its estimate as rerun views, saved, opened and rendered."""
