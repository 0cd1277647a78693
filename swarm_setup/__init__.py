"""Setup of an environment: interface packages that PyPI lacks, compiled navigators."""
