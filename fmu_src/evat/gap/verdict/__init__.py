"""What is to be believed of what was compared, by which constants, and why?"""
