"""Tests with invalid files and messages: valid parts are shown, one warning names the rest."""
