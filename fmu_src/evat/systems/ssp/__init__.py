"""How does a system stand in a file? SSP 1.0 and 2.0: .ssp read as something that a stranger sent, and written as importers read it."""
