"""What does a report show as pictures? Which there are, of which numbers, and how they are drawn on the screen and on paper."""
