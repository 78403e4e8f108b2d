"""How does a folder of data files become an experiment? By guesses, each marked, and questions where there is nothing to guess by."""
