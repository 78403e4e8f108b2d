"""What can be simulated, compared with a measurement and diagnosed? The contact, an FMU, friction on an axis: each a Model."""
