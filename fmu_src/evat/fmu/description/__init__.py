"""What does modelDescription.xml say? The tables of a model in the words of FMI 2 and FMI 3."""
