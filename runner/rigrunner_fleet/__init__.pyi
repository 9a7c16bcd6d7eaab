from rigrunner_fleet import archive as archive
from rigrunner_fleet.notebook import analyse as analyse
from rigrunner_fleet.notebook import open_run as open_run
