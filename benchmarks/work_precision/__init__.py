"""Work-precision studies: problems, participants, settings, fronts and targets."""
