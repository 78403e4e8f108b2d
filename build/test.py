"""One command on a fresh machine: does the project hold together? Format, lint, types, build and tests.

python3 build/test.py [arguments of pytest], for example: python3 build/test.py -k law
"""

import sys

if sys.version_info < (3, 10):
    sys.exit("evat needs Python 3.10 or newer; %s is %d.%d. Run this with a newer one." % ((sys.executable, *sys.version_info[:2])))

import environment

environment.main(environment.test)
