"""`python -m reports` is `halfplane`."""

import sys

from reports.cli import main

sys.exit(main())
