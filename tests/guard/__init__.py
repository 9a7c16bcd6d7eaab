"""Numbers of shipped procedures and of faulty rigs, which change only with a stated reason."""
