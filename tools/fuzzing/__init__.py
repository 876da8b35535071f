"""Sound files of every format that is read, the ways to damage them, and what readers make of the damage."""
