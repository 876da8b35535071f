"""Signals that ask a program to stop, as Ctrl-C does."""

import _thread
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGINT and SIGTERM raise a `KeyboardInterrupt`, which names the signal, in the main thread.

    A program that a script began in the background inherits that SIGINT is ignored, and could not be stopped by it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, _interrupt) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    except Exception as error:
        if is_interrupt(error):
            raise KeyboardInterrupt from error
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


def is_interrupt(error: BaseException | None) -> bool:
    """Whether an error is Ctrl-C, or what Python or a library made of it, as of one that falls into an import."""
    return error is not None and (isinstance(error, KeyboardInterrupt) or is_interrupt(error.__cause__))


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt(signal.Signals(number).name)


def is_heard() -> bool:
    """Whether `interrupt_main` interrupts what the calling thread does."""
    return threading.current_thread() is threading.main_thread() and callable(signal.getsignal(signal.SIGINT))


def interrupt_main() -> None:
    """Interrupt the main thread, also while it sleeps or waits: only a signal to that thread wakes it."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        _thread.interrupt_main()
