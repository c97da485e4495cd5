"""What is made of results files.

file                                  a results file, read
pictures                              curves, maps, sections
sweep_pictures of sweeps and studies  fields_export
compare                               curves scored against one another
judgement                             extremes, windows, work in loops
report                                one HTML page
rivals                                rival lubrication models side by side
"""
