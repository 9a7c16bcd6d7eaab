"""The plugins that ship with Rigrunner; found through entry points, as any other."""
