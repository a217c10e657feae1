"""What sensors need of the model: frames of images, and what of their tags has no effect."""
