"""Does the paper's table 2 come out, and under which conditions? The study, its rooms of calculation, and what it leaves behind."""
