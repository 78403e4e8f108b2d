"""Which output depends on what, and how? Asked of the compiled model, for FMI's ModelStructure."""
