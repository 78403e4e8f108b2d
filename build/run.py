"""One command on a fresh machine: how do the FMUs get built and the paper's figures made?

python3 build/run.py [arguments of `evat run`]
"""

import sys

if sys.version_info < (3, 10):
    sys.exit("evat needs Python 3.10 or newer; %s is %d.%d. Run this with a newer one." % ((sys.executable, *sys.version_info[:2])))

import environment

environment.main(environment.run)
