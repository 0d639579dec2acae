"""The application: the `ballscrew` command, one file for each of its commands."""
