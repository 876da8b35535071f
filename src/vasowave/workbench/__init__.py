"""The workbench: a page on this machine over the same files and functions as the command line."""
