"""Settings of the documentation site: `make docs` builds it into build/site/html."""

from __future__ import annotations

import os
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
BUILD = DOCS.parent / "build" / "site"
sys.path.insert(0, str(DOCS))
os.environ["IPYTHONDIR"] = str(DOCS / "sphinx_parts" / "kernel")  # settings of executed cells
path = (str(DOCS.parent / "notebooks"), os.environ.get("PYTHONPATH", ""))  # for `proofs`
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, path))

from jupyter_cache import get_cache  # noqa: E402
from sphinx_parts import elsewhere, figures  # noqa: E402

from stability.base.version import __version__  # noqa: E402

project = "stability"
author = "The stability developers"
copyright = author
version = release = __version__
language = "en"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.intersphinx",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_parts.site",
]
exclude_patterns = ["films", "sphinx_parts", "*.py", "_made", "**.ipynb_checkpoints"]
root_doc = "index"
nitpicky = True
nitpick_ignore_regex = [
    # rooms behind the public names have no page of their own
    ("py:.*", r"(stability\.|\.\.|_)?[a-z_]+\..*"),
    ("py:.*", r"[A-Z_]\w*"),
]
suppress_warnings = ["mystnb.unknown_mime_type", "config.cache"]

# --- pages ---

myst_enable_extensions = [
    "colon_fence",
    "deflist",
    "dollarmath",
    "fieldlist",
    "attrs_inline",
    "attrs_block",
]
myst_heading_anchors = 4
myst_links_external_new_tab = False

nb_execution_mode = "cache"
nb_execution_cache_path = str(BUILD / "executed" / figures.fingerprint())  # of this package only
# made before pages are read side by side: a reader would take a half-made one for whole
_ = get_cache(nb_execution_cache_path).db
nb_execution_in_temp = True
nb_execution_timeout = 240
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_ipywidgets_js: dict[str, dict[str, str]] = {}  # they would come from a server

# --- reference ---

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # signatures show them; parameters say shapes and units
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
napoleon_attr_annotations = False  # an alias of NumPy would be written out
napoleon_custom_sections = [("Source", "notes_style")]
intersphinx_mapping = elsewhere.mapping(BUILD / "inventories", online="DOCS_ONLINE" in os.environ)
intersphinx_timeout = 20

# --- the look ---

html_theme = "pydata_sphinx_theme"
html_title = f"stability {version}"
html_static_path = ["sphinx_parts/static"]
html_css_files = ["site.css"]
html_extra_path = [str(BUILD / "live")]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False
html_context = {"default_mode": "auto"}  # dark where the reader's system is
html_sidebars = {"index": []}
html_theme_options = {
    "show_prev_next": True,
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "show_toc_level": 2,
    "secondary_sidebar_items": {"**": ["page-toc"], "index": []},
    "footer_start": ["copyright"],
    "footer_end": [],
    "navigation_with_keys": True,
    "back_to_top_button": False,
}
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True
copybutton_exclude = ".linenos, .gp, .go"
linkcheck_timeout = 20
linkcheck_anchors = False
(BUILD / "live").mkdir(parents=True, exist_ok=True)
