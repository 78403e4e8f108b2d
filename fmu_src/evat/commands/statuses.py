"""With which status does a command end? The page on first runs explains them."""

FAILED = 1  # the work was done, and what it says is no
REFUSED = 2  # something was asked that cannot be done
STOPPED = 130  # as of a process that Ctrl-C ends; what was done by then is kept
