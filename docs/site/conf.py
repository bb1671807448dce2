"""How Sphinx makes the site. `tests/docs.sh` calls it with the root of the repository as the source.

The pages stand where they stand in the repository, so that a link holds there as well as on the site.
"""

import pathlib
import sys

import latex2mathml.converter
from docutils import nodes

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bindings/python/src"))  # For the reference of the Python package.

project = "cylfuse"
root_doc = "docs/index"
include_patterns = ["docs/**.md", "*.md", "bindings/*/README.md", "tests/data/README.md"]
exclude_patterns = ["target", ".git", ".ci-work", "docs/site", "docs/drawings", "docs/benchmark", "src", "**/node_modules"]

extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]  # As GitHub writes equations, too.
myst_heading_anchors = 4
myst_url_schemes = {"http": None, "https": None, "site": "../{{path}}"}
suppress_warnings = ["myst.header"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"

html_theme = "furo"
html_title = "cylfuse"
html_show_copyright = False
html_copy_source = False
html_extra_path = ["root"]
html_math_renderer = "mathml"


def inline_math(translator, node):
    translator.body.append(latex2mathml.converter.convert(node.astext()))
    raise nodes.SkipNode


def block_math(translator, node):
    mathml = latex2mathml.converter.convert(node.astext(), display="block")
    # Wide equations scroll on a phone, and the page does not.
    translator.body.append(f'<div style="overflow-x: auto; overflow-y: hidden">{mathml}</div>')
    raise nodes.SkipNode


def setup(app):
    # MathML in the page: browsers show it without a script, so the site needs no network.
    app.add_html_math_renderer("mathml", (inline_math, None), (block_math, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
