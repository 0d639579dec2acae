"""How everything moves with a parameter: the open-loop run, and the score by noise levels: tangent, sensitivity,
averages, score, objective, prior."""
