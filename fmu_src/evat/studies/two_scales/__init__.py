"""Do cycle averages lead a slow machine as every cycle does?"""
