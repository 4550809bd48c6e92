"""Pictures for training: boxes, corrections, augmentation, batches."""
