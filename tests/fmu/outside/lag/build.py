"""Build options of the lag: none."""


def prepare(options, folder, progress):
    """Return the options and no files."""
    return dict(options), []
