"""Where verdicts change along an axis, and what crosses there."""
