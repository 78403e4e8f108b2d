"""What does a set-up read wrong? Gain, zero and clock of all its recordings, and the zero of a velocity at rest."""
