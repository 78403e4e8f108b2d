"""What does the paper print, and what does it leave open? Its tables, conditions that it does not state, constants of its materials."""
