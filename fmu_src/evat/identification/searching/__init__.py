"""How is the best point of the cube looked for? A population from generation to generation, kept in a journal, spread over machines."""
