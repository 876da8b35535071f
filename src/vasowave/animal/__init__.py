"""One animal from its recording to everything the study asks of it, as one labelled result."""
