"""What does an identification leave behind, and what does it look like?"""
