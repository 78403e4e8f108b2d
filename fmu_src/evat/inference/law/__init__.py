"""What of the friction law itself is unknown in every fit? Its form, and how its bristles were bent at the start."""
