"""What does it look like? One picture each, by matplotlib."""
