"""The site of the documents: README.md and docs/, and the reference that Doxygen makes of the headers.

scripts/docs.sh gives the folder of the reference in MBSRANK_REFERENCE, that of MathJax in MBSRANK_MATHJAX, and in
MBSRANK_PLAY the page that runs models, or nothing.
SPDX-License-Identifier: BSD-3-Clause
"""
import os
import re
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from docutils import nodes

project = "libmbsrank"
author = "the authors of libmbsrank"
root_doc = "README"
extensions = ["myst_parser", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
exclude_patterns = ["build*", "demo-output", "src", "tests", "include", "cmake", "scripts", "examples", "docs/site", "debian", "web",
                    "packaging", ".*"]
html_theme = "sphinx_rtd_theme"
html_theme_options = {"navigation_depth": 3, "collapse_navigation": False}
templates_path = ["templates"]
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_title = "libmbsrank"
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_SVG"
myst_update_mathjax = False  # that is for MathJax 3
mathjax2_config = {
    "messageStyle": "none",
    "tex2jax": {"processClass": "tex2jax_process|mathjax_process|math"},
}
pygments_style = "friendly"
highlight_language = "none"
suppress_warnings = ["myst.header", "misc.highlighting_failure"]

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = Path(os.environ["MBSRANK_REFERENCE"])
PLAY = os.environ.get("MBSRANK_PLAY")
html_context = {"play": bool(PLAY)}

# In the order of reading; the README is the first page.
TOCTREE = """

```{toctree}
:hidden:
:caption: Using it

docs/getting_started
docs/neighbours
docs/conventions
docs/joints_and_forces
docs/closed_loops
docs/contact
docs/flexible
docs/small_masses
docs/files
docs/program
docs/viewer
docs/python
docs/javascript
docs/fmu
docs/real_time
docs/embedding
```

```{toctree}
:hidden:
:caption: How it works

docs/theory
docs/rank_and_index
docs/dae_forms
docs/newton
docs/derivatives
docs/linear
docs/study
docs/parameters
docs/performance
docs/validation
docs/architecture
docs/renamed
bench/README
CHANGELOG
CONTRIBUTING
SECURITY
docs/release
```
"""


def add_toctree(_app, name, source):
    """The README gets the list of pages; ```output, which GitHub shows as it is, is plain text."""
    if name == root_doc:
        source[0] += TOCTREE
    source[0] = source[0].replace("```output\n", "```text\n")


def reference_pages():
    """Page and anchor of all that the headers declare, by name."""
    pages = {}
    for compound in ElementTree.parse(REFERENCE / "reference.tag").getroot():
        name, file = compound.findtext("name"), compound.findtext("filename")
        if compound.get("kind") == "file":
            pages["mbsrank/" + name] = file if file.endswith(".html") else file + ".html"
        if compound.get("kind") == "struct":
            pages[name] = file if file.endswith(".html") else file + ".html"
        for member in compound.findall("member"):
            anchored = f"{member.findtext('anchorfile')}#{member.findtext('anchor')}"
            pages.setdefault(member.findtext("name"), anchored)
            for value in member.findall("enumvalue"):
                pages.setdefault(value.text, f"{value.get('anchorfile')}#{value.get('anchor')}")
    return pages


def link_names(app, doctree, name):
    """Names of functions, types and headers in the text lead to the reference."""
    up = "../" * name.count("/")
    pages = app.env.reference_pages
    for literal in list(doctree.findall(nodes.literal)):
        word = re.match(r"^(?:mbsr_\w+|MBSR_\w+)", literal.astext())
        target = pages.get(word.group(0)) if word else None
        if target and not isinstance(literal.parent, nodes.reference):
            link = nodes.reference("", "", refuri=f"{up}reference/{target}", internal=True)
            literal.replace_self(link)
            link += literal
    for link in doctree.findall(nodes.reference):
        header = re.search(r"include/(mbsrank/\w+\.h)$", link.get("refuri", ""))
        if header:
            link["refuri"] = f"{up}reference/{pages[header.group(1)]}"


def link_files(_app, doctree):
    """Links to files of the project that are no pages: headers to the reference, others are copied."""
    from sphinx import addnodes

    for link in list(doctree.findall(addnodes.download_reference)):
        target = link.get("reftarget", "")
        header = re.search(r"include/(mbsrank/\w+\.h)$", target)
        if header:
            new = nodes.reference("", "", *link.children, refuri="include/" + header.group(1), internal=True)
            link.replace_self(new)


def read_reference(app):
    app.env.reference_pages = reference_pages()


def finish(app, _exception):
    """index.html is the README; the reference and MathJax stand beside the pages."""
    out = Path(app.outdir)
    other_fonts = shutil.ignore_patterns("Asana-Math", "Gyre-*", "Latin-Modern", "Neo-Euler", "STIX-Web")
    shutil.copyfile(out / "README.html", out / "index.html")
    shutil.copytree(REFERENCE / "reference", out / "reference", dirs_exist_ok=True)
    if PLAY:
        (out / "docs" / "play").mkdir(parents=True, exist_ok=True)
        shutil.copyfile(PLAY, out / "docs" / "play" / "index.html")
    source, target = Path(os.environ["MBSRANK_MATHJAX"]), out / "_static" / "mathjax"
    for part in ["config", "jax/output/SVG", "jax/input/TeX", "jax/element", "extensions"]:
        shutil.copytree(source / part, target / part, ignore=other_fonts, dirs_exist_ok=True)
    shutil.copyfile(source / "MathJax.js", target / "MathJax.js")


def setup(app):
    app.connect("builder-inited", read_reference)
    app.connect("source-read", add_toctree)
    app.connect("doctree-read", link_files)
    app.connect("doctree-resolved", link_names)
    app.connect("build-finished", finish)
