"""What an environment is given once: interface packages that PyPI lacks, compiled navigators."""
