from rigrunner import archive as archive
from rigrunner.notebook import analyse as analyse
from rigrunner.notebook import open_run as open_run

__version__: str
