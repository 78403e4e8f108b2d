"""What was found out with the package? Campaigns, comparisons with the paper, the main job; each can be run again."""
