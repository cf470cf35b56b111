"""The report: claims checked, contenders compared, shown as tables, figures and one HTML page.

Run as ``python -m reports``; output goes to reports/out.
"""
