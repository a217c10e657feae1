"""Pictures of cameras: messages as the JPEG and PNG that browsers show."""
