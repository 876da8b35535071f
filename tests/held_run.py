"""A run in another process that does nothing, until it is stopped or killed."""

import signal
import time
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path

from vasowave.base.runtime import interruptible
from vasowave.study.running import running


def held_run(folder, deaf=False):
    """Return the process of a run of three animals, one of which is done.

    Parameters
    ----------
    deaf : bool
        Whether it inherits that interrupts are ignored, as what a script begins in the background does.
    """
    context = get_context("forkserver")
    context.set_forkserver_preload(["vasowave.study.running.run_state"])  # which takes seconds to load, once
    begun = context.Event()
    process = context.Process(target=_hold, args=(str(folder), deaf, begun))
    process.start()
    assert begun.wait(120)
    return process


def _hold(folder, deaf, begun):
    signal.signal(signal.SIGINT, signal.SIG_IGN if deaf else signal.default_int_handler)
    with suppress(KeyboardInterrupt), interruptible(), running(Path(folder), 3) as run:
        run.write(stage="computing", done=1, left=7.0)
        begun.set()
        time.sleep(600)
