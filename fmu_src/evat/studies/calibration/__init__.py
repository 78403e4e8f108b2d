"""Which weights should the diagnosis judge by? Simulated cases, and what each constant does to them."""
