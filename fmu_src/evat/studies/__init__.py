"""What was found out with the package? Campaigns, comparisons with the paper, its four materials by the FMU; each can be run again."""
