"""Configuration of the documentation site: Sphinx, MyST, Furo, sphinx-gallery."""

import re
import tomllib
from pathlib import Path

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

DOCS = Path(__file__).resolve().parent
ROOT_PAGES = ("architecture", "changelog", "contributing")
README_PAGES = ("cases", "checker", "simulators")
PROJECT = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
KEYS = re.findall(r"^@\w+\{(\w+),", (DOCS / "references.bib").read_text("utf-8"), flags=re.M)
CITED = re.compile(rf"\[((?:{'|'.join(KEYS)})(?:,\s+(?:{'|'.join(KEYS)}))*)\](?![(\w])")
"""Keys in brackets, as the pages cite their sources."""
LINK = re.compile(r"\[([^\]]*)\]\(([^)#\s:]+)(#[^)]*)?\)")
PAGES = {
    DOCS / "decisions": "/decisions/index.md",
    DOCS / "studies": "/studies/index.md",
    **{DOCS.parent / f"{name.upper()}.md": f"/development/{name}.md" for name in ROOT_PAGES},
    **{DOCS.parent / f"{name}/README.md": f"/development/{name}.md" for name in README_PAGES},
}
"""File or folder outside the site -> the page that stands for it."""

project = PROJECT["name"]
author = "The msvalidate developers"
html_theme = "furo"
html_title = project
html_static_path = []
extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "sphinxcontrib.bibtex",
]
exclude_patterns = ["_build", "README.md", "gallery/README.rst", "tutorials/README.rst"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
suppress_warnings = [
    "bibtex.missing_field",  # a field that is not certain is left out
    "config.cache",  # `save_figures` is a function
]
bibtex_bibfiles = ["references.bib"]
bibtex_default_style = "plain"
numpydoc_show_class_members = False
autodoc_typehints = "none"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True


def save_figures(_block, block_vars, gallery_conf):
    """Save figures that pyplot does not manage, such as those of `plot`, each once."""
    names, paths = block_vars["example_globals"], []
    saved = names.setdefault("_saved_figures", [])
    for figure in [each for each in names.values() if isinstance(each, Figure)]:
        if figure not in saved and getattr(figure, "number", None) is None:
            saved.append(figure)
            paths.append(next(block_vars["image_path_iterator"]))
            figure.savefig(paths[-1])
    return figure_rst(paths, gallery_conf["src_dir"])


sphinx_gallery_conf = {
    "examples_dirs": ["gallery", "tutorials"],
    "gallery_dirs": ["auto_gallery", "auto_tutorials"],
    "within_subsection_order": "FileNameSortKey",
    "show_memory": False,
    "image_scrapers": (save_figures, "matplotlib"),
    "min_reported_time": 1e9,
}


def adapt(text, folder):
    """Return Markdown with citations, and links to what the site contains."""

    def link(match):
        words, target, anchor = match[1], (folder / match[2]).resolve(), match[3] or ""
        if target in PAGES:
            return f"[{words}]({PAGES[target]}{anchor})"
        outside = not target.is_relative_to(DOCS)
        if target.is_dir() or (outside and target.suffix == ".md"):
            return words
        if not target.exists():
            return match[0]
        path = f"../{target.relative_to(DOCS.parent)}" if outside else target.relative_to(DOCS)
        return f"[{words}](/{path}{anchor})"

    text = CITED.sub(lambda match: f"{{cite:p}}`{''.join(match[1].split())}`", text)
    return LINK.sub(link, text)


def write_list(app, error):
    """Write llms.txt: the title and the Markdown of each page."""
    titles = app.env.titles.items()
    lines = [f"- [{title.astext()}](_sources/{name}.md.txt)" for name, title in titles]
    if error is None:
        text = "\n".join([f"# {project}", "", *sorted(lines), ""])
        Path(app.outdir, "llms.txt").write_text(text, encoding="utf-8")


def setup(app):
    """Connect the changes of sources."""
    files = {page.removesuffix(".md"): path for path, page in PAGES.items() if path.suffix == ".md"}

    def read(app, name, source):
        path = files.get(f"/{name}", DOCS / name)
        if path.suffix == ".md":  # the page stands for a file outside this folder
            app.env.note_dependency(str(path))
            source[0] = path.read_text(encoding="utf-8")
        source[0] = adapt(source[0], path.parent)

    app.connect("source-read", read)
    app.connect("build-finished", write_list)
