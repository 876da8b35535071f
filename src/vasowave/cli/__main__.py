"""``python -m vasowave.cli`` is the command ``vasowave``."""

from vasowave.cli import run

if __name__ == "__main__":
    run()
