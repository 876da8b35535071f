"""The compiled 1D solver: grid, kernels, periodic state, simulation."""
