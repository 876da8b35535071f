"""What an image shows before anything is measured, and what to do with it next."""
