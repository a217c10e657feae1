"""Data of launch files and of evaluated launches, whatever language the file is in."""
