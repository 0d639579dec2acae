"""A bus: who listens, who shares it, who sends."""
