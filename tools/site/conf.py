"""Settings of Sphinx for the site of the documents (tools/make_site.py)."""

project = "meshmark"
author = "The meshmark founders"
extensions = ["myst_parser"]
exclude_patterns = [".doctrees"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # results that are parts of reports begin with headings of a lower level
highlight_language = "none"
html_theme = "furo"
html_title = "meshmark"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}
