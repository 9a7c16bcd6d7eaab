"""Numbers of shipped procedures and of faulty rigs that must not move unless a commit says why."""
