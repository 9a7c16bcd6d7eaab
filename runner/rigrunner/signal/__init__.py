"""Pure numerical building blocks on arrays: public, stable, without I/O."""
