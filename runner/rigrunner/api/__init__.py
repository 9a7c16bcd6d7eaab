"""The contracts between Rigrunner and its plugins.

Stable and public. A plugin or a report imports `rigrunner.api` and `rigrunner.signal`, nothing else
of Rigrunner's. The modules that a plugin's declaration needs (`errors`, `quantity`, `settings`,
`instruments`, `devices`, `events`, `hooks`) load without numpy.
"""
