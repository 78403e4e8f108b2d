"""What may explain the gap? Effects looked for in a part of the data, fitted to all, compared."""
