"""The needs of a running process: compiled kernels, threads, memory, locks."""

from vasowave.base.runtime.interrupts import interruptible as interruptible
from vasowave.base.runtime.kept import digest_of as digest_of
from vasowave.base.runtime.kept import keep as keep
from vasowave.base.runtime.kept import program as program
from vasowave.base.runtime.kept import recall as recall
from vasowave.base.runtime.thread_limits import VARIABLE as VARIABLE
from vasowave.base.runtime.thread_limits import cores as cores
from vasowave.base.runtime.thread_limits import threads as threads
from vasowave.base.runtime.writing import PART as PART
from vasowave.base.runtime.writing import Part as Part
from vasowave.base.runtime.writing import append as append
from vasowave.base.runtime.writing import put as put

__all__: list[str]
