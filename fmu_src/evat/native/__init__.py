"""How does Python reach the compiled C? Compiler, libraries, the contact and its partners as objects, many sets at once."""
