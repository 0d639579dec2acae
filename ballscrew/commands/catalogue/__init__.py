"""Effects and the models made of them: effects, show, add, new_effect."""
