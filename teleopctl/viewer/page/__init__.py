"""The page's frame: who may open it, the server behind it, and pieces of HTML."""
