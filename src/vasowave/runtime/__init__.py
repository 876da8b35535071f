"""The needs of a running process: compiled kernels, threads, memory, locks."""
