"""What do the data say about each parameter, why, and what would tell more?"""
