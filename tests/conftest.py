"""No test reads or leaves anything in the cache folder of the user; one that is about it has a folder of its own."""

import os

os.environ["SHORTFINAL_CACHE"] = "off"
