"""How everything moves with a parameter: the open-loop run, and the score: tangent, sensitivity, score,
objective, prior."""
