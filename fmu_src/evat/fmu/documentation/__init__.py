"""What does a person read and see who opens the FMU? documentation/index.html and its pictures."""
