"""What the running process needs: compiled kernels, threads, memory, locks."""
