"""Pictures of cameras on the page: as many of them as make sense, and put where they are shown."""
