"""``ament_copyright``. Checks of copyright headers, which are skipped here."""
