"""In which other world is the gap diagnosis judged? One written apart from the first, from the issue and the literature alone."""
