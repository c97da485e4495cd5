"""The command line, one file a command; what several of them do is in common.py. cli.py loads a command when it is called."""
