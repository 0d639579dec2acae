"""How everything moves with a parameter: columns, and the score: tangent, sensitivity, score, objective."""
