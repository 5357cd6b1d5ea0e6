from .failures import attempt as attempt
from .motion.drivers import Driver as Driver
from .spectrum.cases import CASES as CASES
from .spectrum.cases import Case as Case
from .spectrum.routes import AutomaticJacobian as AutomaticJacobian
from .spectrum.routes import Route as Route
