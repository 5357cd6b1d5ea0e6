from ..bodies.disk_polynomials import exact_polynomial as exact_polynomial
from .to_c import c_code as c_code
from .to_continuation import auto_input as auto_input
from .to_continuation import bifurcationkit_input as bifurcationkit_input
from .to_latex import latex as latex
