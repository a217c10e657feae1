"""Controllers: small classes that turn states and goals into commands."""
