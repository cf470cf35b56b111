"""How it is shown: claims checked, contenders compared, tables, figures and one page.

``python -m reports`` runs it; what it writes is in reports/out.
"""
