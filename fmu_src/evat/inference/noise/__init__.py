"""What are the recordings' own errors? Estimated from repeats, means and what neighbours tell."""
