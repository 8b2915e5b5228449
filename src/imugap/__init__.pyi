from imugap.api.checks import Checked as Checked
from imugap.api.checks import check as check
from imugap.api.discoveries import Discovered as Discovered
from imugap.api.discoveries import discover as discover
from imugap.api.drives import Driven as Driven
from imugap.api.drives import drive as drive
from imugap.api.estimates import Estimated as Estimated
from imugap.api.estimates import estimate as estimate
from imugap.api.estimates import export as export
from imugap.api.indices import Characterised as Characterised
from imugap.api.indices import indices as indices
from imugap.api.logs import DeviceLog as DeviceLog
from imugap.api.logs import read as read
from imugap.api.logs import simulate as simulate
from imugap.api.walks import Walked as Walked
from imugap.api.walks import walk as walk
from imugap.log import LogError as LogError
from imugap.model import ErrorModel as ErrorModel

__version__: str
