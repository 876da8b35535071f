"""Images from files, checked, on a grid of cubes."""
