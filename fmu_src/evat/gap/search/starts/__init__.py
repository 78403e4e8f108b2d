"""Where does the fit of an effect start? At points of a design or peaks of a periodogram, by what linear sums promise there."""
