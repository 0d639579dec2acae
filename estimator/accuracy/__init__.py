"""How far an estimate or a prediction is from what was measured."""
