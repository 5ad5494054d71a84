"""`python -m ilon` is the `ilon` command."""

import sys

from ._cli import main

sys.exit(main())
