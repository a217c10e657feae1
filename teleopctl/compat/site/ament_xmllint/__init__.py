"""``ament_xmllint``. Checks that XML files are well-formed."""
