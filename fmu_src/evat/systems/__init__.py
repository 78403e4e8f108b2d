"""How does the contact run in a machine? Systems of FMUs: declared in ssp/, written as .ssp, read, coupled, swept.

The reader and the coupling know no component of ours: any .ssp of co-simulation FMUs with real signals will do.
"""
