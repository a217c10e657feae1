"""Hardware components: what stands between controllers and motors."""
